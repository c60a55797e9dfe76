"""What one request may ask for."""

from __future__ import annotations

from pydantic import Field
from pydantic_settings import BaseSettings, SettingsConfigDict

from rpr_solver.errors import FieldProblem, InputError

MIN_DIGITS = 15
MAX_DIGITS = 1000


class Limits(BaseSettings):
    """What one request may ask for. Exceeding a limit is a 4xx that names it; `/v1/limits` shows them."""

    model_config = SettingsConfigDict(env_prefix="RPR_CUSPS_", frozen=True, extra="ignore")

    max_slices: int = Field(default=2000, ge=1, description="slices in one request, at most")
    max_article_slices: int = Field(
        default=50, ge=1, description="slices in one request by the article's method, at most"
    )
    max_samples: int = Field(
        default=50, ge=1, description="points of cusp curves in each interval between transitions, at most"
    )
    min_digits: int = Field(
        default=MIN_DIGITS,
        ge=MIN_DIGITS,
        le=MAX_DIGITS,
        description="significant digits of an answer, at least",
    )
    max_digits: int = Field(
        default=MAX_DIGITS,
        ge=MIN_DIGITS,
        le=MAX_DIGITS,
        description="significant digits of an answer, at most",
    )
    default_digits: int = Field(
        default=90, ge=MIN_DIGITS, le=MAX_DIGITS, description="significant digits when a request does not say"
    )
    max_number_digits: int = Field(
        default=400,
        ge=1,
        le=4000,
        description="digits of an input number's numerator and of its denominator, at most",
    )
    max_body_bytes: int = Field(default=1 << 20, ge=1, description="bytes of a request body, at most")
    max_wait_seconds: int = Field(
        default=30, ge=0, description="seconds that `Prefer: wait` can hold a request"
    )


class LimitError(InputError):
    """The input is right, but larger than a limit allows."""

    def __init__(self, field: str, limit: str, value: int, sent: str) -> None:
        self.limit, self.value, self.sent = limit, value, sent
        super().__init__([FieldProblem(field, f"{sent}; the limit {limit} is {value}")])
