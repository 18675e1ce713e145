"""Checks of input: numbers in a range, choices, and the texts of their errors."""

import math
from collections.abc import Callable, Collection, Iterable
from numbers import Real
from typing import Any, TypeVar

from beamviz.errors import InvalidInput, did_you_mean

T = TypeVar("T")


def together(checks: Iterable[Callable[[], T]]) -> list[T]:
    """The values of some checks, or InvalidInput with the errors of all."""
    values, errors = [], []
    for check in checks:
        try:
            values.append(check())
        except InvalidInput as error:
            errors.append(error)
    if len(errors) > 1:
        raise InvalidInput("; ".join(map(str, errors)))
    if errors:
        raise errors[0]
    return values


def is_number(value: object) -> bool:
    """Whether a value is a real number: no truth, no text."""
    return isinstance(value, (float, int, Real)) and not isinstance(value, bool)


def check_float(name: str, value: object, low: float = -math.inf, high: float = math.inf) -> float:
    """`value` as a float in low .. high, or InvalidInput with its name and the range."""
    number, rule = checked(value, low, high)
    if number is None:
        raise InvalidInput(f"{name} = {shown_text(value)}: must {rule}")
    return number


def checked(value: object, low: float, high: float) -> tuple[float | None, str]:
    """`value` as a float in low .. high; else None, and what it must do."""
    if not is_number(value):
        return None, f"be a {number_text(low, high)}"
    number = as_float(value)
    if not (math.isfinite(number) and low <= number <= high):
        return None, range_text(low, high)
    return number + 0.0, ""  # -0.0 becomes 0.0


def as_float(value: Any) -> float:
    """A number as a float, infinite where it is too large for one."""
    try:
        return float(value)
    except OverflowError:
        return math.inf


def shown_text(value: object) -> str:
    """A value in the text of an error."""
    return full_text(as_float(value)) if is_number(value) else repr(value)


def check_floats(
    name: str, values: object, low: float = -math.inf, high: float = math.inf
) -> tuple[float, ...]:
    """A sequence of numbers as a tuple of floats in low .. high, or InvalidInput with all values
    that are not."""
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise InvalidInput(f"{name} = {values!r}: must be a sequence of numbers")
    numbers, wrong = [], dict[str, list[str]]()  # wrong: the values by what they must do
    for value in values:
        number, rule = checked(value, low, high)
        if number is None:
            wrong.setdefault(rule, []).append(shown_text(value))
        else:
            numbers.append(number)
    if wrong:
        texts = (f"{name} = {', '.join(those)}: must {rule}" for rule, those in wrong.items())
        raise InvalidInput("; ".join(texts))
    return tuple(numbers)


def check_choice(name: str, value: Any, choices: Collection[str]) -> str:
    """`value` if it is one of `choices`, else InvalidInput."""
    if not isinstance(value, str) or value not in choices:
        hint = did_you_mean(value, choices)
        raise InvalidInput(f"{name} = {value!r}: must be one of {', '.join(choices)}{hint}")
    return value


def check_positive(name: str, value: object) -> float:
    """`value` as a finite float above 0, or InvalidInput."""
    number = check_float(name, value, 0.0)
    if number == 0:
        raise InvalidInput(f"{name} = 0: must be above 0")
    return number


def check_int(name: str, value: object, low: int, high: int) -> int:
    """`value` as an integer in low .. high, or InvalidInput with its name and the range."""
    rule = f"must be a whole number in {low} .. {high}"
    try:
        number = check_float(name, value, low, high)
    except InvalidInput as error:
        raise InvalidInput(f"{str(error).split(': must')[0]}: {rule}") from None
    if number != int(number):
        raise InvalidInput(f"{name} = {full_text(number)}: {rule}")
    return int(number)


def range_text(low: float, high: float) -> str:
    """What a number must do to be in a range."""
    if math.isfinite(high):
        return f"lie in {low:g} .. {high:g}"
    return "be 0 or more" if low == 0 else "be finite"


def number_text(low: float, high: float) -> str:
    """A number in a range, in words."""
    if math.isfinite(high):
        return f"number in {low:g} .. {high:g}"
    return "number, 0 or more" if low == 0 else "finite number"


def full_text(number: float) -> str:
    """A number with all its digits: just outside a limit it does not read like the limit."""
    return repr(number).removesuffix(".0")
