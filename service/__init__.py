"""The interfaces of rpr-cusps: the HTTP service and the command line.

Errors, in addition to those of the solver (`rpr_solver.errors`):

ValueError
├── SecretError             webhooks.target: the secrets of webhooks cannot be used
├── JsonError               schemas.document: a body or a file is not strict JSON
└── InputError              (the solver's)
    └── LimitError          schemas.limits: the request is valid but exceeds a limit
RuntimeError
└── StackError              errors: the stack cannot run
    ├── BadAddressError     errors: the address of Redis cannot be understood
    └── EmbeddedError       errors: the embedded server cannot be started
        └── NoServerError   errors: it is not installed
Exception
├── ProblemError            api.problems: answered as a problem document; all other errors become one
├── ChunkFailedError        (the worker's) worker.process.tasks: a chunk, or a part of it, has no answer
├── QueueFullError          (the worker's) worker.jobs.plan: the lane of a new job holds too much work
├── ResultLostError         (the worker's) worker.answers.tables: a result expired while it was read
├── QuotaError              (the worker's) worker.jobs.quotas: a client holds too much of the queue
├── OutputError             cli.output: what a command prints cannot be written
├── ItemsLostError          (the worker's) worker.jobs.attempts: the items of a batch are not there
├── RefusedError            webhooks.deliverer: the address of a callback may not be reached
├── TooManyCallbacksError   webhooks.callbacks: a job has as many as it may have
├── ServiceError            errors: the service refused, failed, or cannot be reached
├── ArchiveAwayError        (the worker's) worker.answers.archive: the archive does not answer
├── UnreachableError        (the worker's) worker.connection: Redis does not answer at its URL
└── WorkerError             (the worker's) worker.process.program: the worker cannot start
"""

from rpr_solver import __version__

__all__ = ["__version__"]
