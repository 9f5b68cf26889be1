"""Which networks restore images? The list; a new one is a module here and a line in it."""

from collections.abc import Mapping
from types import MappingProxyType

from lrsr.sr.networks.edsr import EDSR
from lrsr.sr.networks.fsrcnn import FSRCNN
from lrsr.sr.networks.fusion import Fusion
from lrsr.sr.networks.imdn import IMDN
from lrsr.sr.networks.network import Network
from lrsr.sr.networks.sparnet import SPARNet
from lrsr.sr.networks.srcnn import SRCNN

#: Every network by the name that its card gives.
NETWORKS: Mapping[str, type[Network]] = MappingProxyType(
    {
        "srcnn": SRCNN,
        "fsrcnn": FSRCNN,
        "edsr": EDSR,
        "imdn": IMDN,
        "sparnet": SPARNet,
        "fusion": Fusion,
    }
)
