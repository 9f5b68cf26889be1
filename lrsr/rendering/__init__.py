"""From a head to the light on the film, by Mitsuba 3."""
