"""Closed-chain mechanisms on Pinocchio: the equivalent Jacobian J_eq = J − J* K*⁻¹ K.

`__init__.pyi` lists the public names. So `import pmjac_pin` is quick, as the command line needs it
to be, which has to end without a word when it is interrupted while everything else is imported.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
