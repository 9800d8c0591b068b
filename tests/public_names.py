"""Public names of the package, as `strainwave.name` and `strainwave.namespace.name`."""

import strainwave
from strainwave.base.above import namespaces

TOP = strainwave.__all__
PUBLIC = [*TOP, *(f"{space}.{name}" for name, space in namespaces().items() if name not in TOP)]
