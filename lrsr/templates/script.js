// Tables that can be sorted and copied, faces that can be looked at closely. Without it the page says the same.
"use strict";
const wordsOf = (cell) => cell.innerText.trim();
const numberOf = (cell) => {
  const found = wordsOf(cell).replaceAll(",", "").replaceAll("−", "-").match(/[-+]?\d*\.?\d+(e[-+]?\d+)?/i);
  return found ? Number(found[0]) : NaN;
};

function sort(table, column, rising) {
  const compare = (a, b) => {
    const [one, other] = [a, b].map((row) => row.cells[column]);
    const [x, y] = [one, other].map(numberOf);
    if (column > 0 && (isNaN(x) || isNaN(y))) return isNaN(x) - isNaN(y);  // what is not known comes last
    return (rising ? 1 : -1) * (column > 0 ? x - y : wordsOf(one).localeCompare(wordsOf(other), undefined, { numeric: true }));
  };
  const groups = [[]];  // rows stay below the heading of their group
  for (const row of table.tBodies[0].rows) row.classList.contains("group") ? groups.push([row]) : groups.at(-1).push(row);
  for (const group of groups) {
    const heading = group[0]?.classList.contains("group") ? group.splice(0, 1) : [];
    table.tBodies[0].append(...heading, ...group.sort(compare));
  }
}

function copy(table, button) {
  const rows = [...table.rows].map((row) => [...row.cells].map((cell) => wordsOf(cell).replace(/\s+/g, " ")).join("\t"));
  const text = document.createElement("textarea");  // the clipboard's newer interface is closed to files on disk
  text.value = rows.join("\n");
  document.body.append(text);
  text.select();
  button.textContent = document.execCommand("copy") ? "copied" : "could not copy";
  text.remove();
}

function act(element, name, what) {
  element.tabIndex = 0;
  element.role = "button";
  element.title = name;
  element.addEventListener("click", what);
  element.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    what();
  });
}

for (const table of document.querySelectorAll("table:not(.sheet, .settings)")) {
  const titles = table.tHead ? [...table.tHead.rows[0].cells] : [];
  for (const title of table.tBodies[0].rows.length > 1 ? titles : []) {
    act(title, "Sort by this column", () => {
      const rising = title.ariaSort !== "ascending";
      for (const other of titles) other.ariaSort = null;
      title.ariaSort = rising ? "ascending" : "descending";
      sort(table, title.cellIndex, rising);
    });
  }
  const button = document.createElement("button");
  button.className = "copy";
  button.textContent = "copy table";
  button.addEventListener("click", () => copy(table, button));
  (table.closest(".scroll") ?? table).after(button);
}

const near = document.createElement("dialog");
near.append(document.createElement("img"), document.createElement("p"));
near.addEventListener("click", () => near.close());
document.body.append(near);
for (const face of document.querySelectorAll(".sheet img")) {
  act(face, "Look closely", () => {
    near.firstChild.src = face.src;
    near.firstChild.alt = near.lastChild.textContent = `${face.alt}, ${face.naturalWidth} × ${face.naturalHeight} px`;
    near.showModal();
  });
}
