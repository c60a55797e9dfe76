"""The faces of rpr-cusps: the HTTP service and the command line.

What can go wrong here, beside the solver's own errors (`rpr_solver.errors`):

ValueError
├── JsonError               schemas.exact_json: a body or a file is not strict JSON
└── InputError              (the solver's)
    └── LimitError          schemas.limits: the request is right, but larger than a limit allows
RuntimeError
└── StackError              stack.errors: the stack cannot run
    └── EmbeddedError       stack.errors: the embedded server cannot be started
Exception
├── ProblemError            api.problems: answered as a problem document; whatever else goes wrong becomes one
├── ServiceError            errors: the service refused, failed, or cannot be reached
└── WorkerError             (the worker's) worker.process.worker: no Redis, or no longer
"""

from importlib.metadata import version

__version__ = version("rpr-cusps")

__all__ = ["__version__"]
