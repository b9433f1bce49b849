"""Checks arguments that are one flag, number, word or text. Errors name the argument."""

from __future__ import annotations

import ctypes
import numbers
import operator
import os
from typing import TYPE_CHECKING, Any, Dict, Iterable, List, Union

import numpy as np

from ._call import raise_on_failure
from ._library import lib

if TYPE_CHECKING:
    from ._arrays import WantName


def counted(count: int, noun: str) -> str:
    """Returns a number and its noun, for a message."""
    return f"{count} {noun}" + ("" if count == 1 else "s")


def shown(value: Any) -> str:
    """Returns a value for a message, in one line."""
    if value is None or isinstance(value, (str, bytes, bool, numbers.Number, np.generic, list, tuple)):
        plain = value.item() if isinstance(value, np.generic) else value
        try:
            text = repr(plain)
        except ValueError:  # an int of more digits than Python prints
            return "a number of too many digits"
        text = " ".join(text.split())
        return text if len(text) <= 80 else text[:80] + "..."
    return f"of type {type(value).__name__}"


def _without_dimensions(value: Any) -> Any:
    """Returns the number of an array without dimensions, and anything else as it is."""
    return value[()] if isinstance(value, np.ndarray) and value.ndim == 0 and not np.ma.isMaskedArray(value) else value


def as_flag(value: Any, name: str) -> bool:
    """Returns a flag, also one of NumPy, or the number 0 or 1."""
    value = _without_dimensions(value)
    is_flag = isinstance(value, (bool, np.bool_)) or (isinstance(value, numbers.Integral) and value in (0, 1))
    if not is_flag:
        raise TypeError(f"{name} is {shown(value)}: give True or False")
    return bool(value)


def as_number(value: Any, name: str) -> float:
    """Returns a real number, which may be infinite or NaN."""
    value = _without_dimensions(value)
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, numbers.Real):
        raise TypeError(f"{name} is {shown(value)}: give a number")
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{name} is {shown(value)}: float64 cannot hold it") from None


def as_count(value: Any, name: str, bits: int) -> int:
    """Returns a whole number below 2**bits."""
    value = _without_dimensions(value)
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, numbers.Integral):
        raise TypeError(f"{name} is {shown(value)}: give a whole number")
    number = operator.index(value)
    if not 0 <= number < 2**bits:  # ctypes would wrap it silently
        raise ValueError(f"{name} is {shown(number)}: it must be from 0 to {2**bits - 1}")
    return number


def as_axis(value: Any, name: str) -> int:
    """Returns 0, 1 or 2, or -1 for None."""
    if value is None:
        return -1
    number = _without_dimensions(value)
    if isinstance(number, (bool, np.bool_)) or not isinstance(number, numbers.Integral) or number not in (0, 1, 2):
        raise ValueError(f"{name} is {shown(value)}: give 0, 1 or 2, or None")
    return int(number)


def as_each_axis(value: Any, name: str, axes: int = 3) -> List[int]:
    """Returns a whole number of at least 1, below 2**31, for each axis, also from one for all."""
    try:
        given = [value] * axes if _without_dimensions(value) is not value or not hasattr(value, "__len__") else list(value)
        counts = [as_count(number, name, 31) for number in given]
    except (TypeError, ValueError):
        counts = []
    if len(counts) != axes or min(counts) < 1:
        raise ValueError(f"{name} is {shown(value)}: give {'three' if axes == 3 else 'two'} whole numbers of at least 1, or one for all")
    return counts


def as_word(word: Any, name: str, words: Dict[str, Any]) -> Any:
    """Returns the value of a word."""
    if not isinstance(word, str) or word not in words:
        raise ValueError(f"{name} is {shown(word)}: the words are {', '.join(words)}")
    return words[word]


def require_one_of(word: Any, name: str, words: Iterable[str]) -> None:
    """Refuses all except these words and None."""
    if word is not None:
        as_word(word, name, dict.fromkeys(words))


def as_text(text: Any, name: str) -> bytes:
    if not isinstance(text, str):
        raise TypeError(f"{name} is {shown(text)}: give a text")
    if "\0" in text:
        raise ValueError(f"{name} is {shown(text)}: remove the zero character")
    try:
        return text.encode()
    except UnicodeEncodeError:
        raise ValueError(f"{name} is {shown(text)}: half of a character cannot be written as UTF-8") from None


def as_path(path: Any, name: str) -> str:
    try:
        text = os.fsdecode(path)
    except TypeError:
        raise TypeError(f"{name} is {shown(path)}: give the name of a file or folder") from None
    try:
        if text and b"\0" not in os.fsencode(text):
            return text
    except UnicodeEncodeError:
        pass
    raise ValueError(f"{name} is {shown(text)}: give the name of a file or folder")


def as_want(want: Union[str, Iterable[WantName]]) -> int:
    """Returns the bits of these words and names of arrays. The library adds the arrays that they imply."""
    names: Any = want
    if not isinstance(names, str):
        try:
            names = list(want)
        except TypeError:
            raise TypeError(f"want is {shown(want)}: give names of arrays") from None
        for name in names:
            if not isinstance(name, str):
                raise TypeError(f"want has {shown(name)}: give names of arrays")
        if not names:
            return 0
        names = ",".join(names)
    bits = ctypes.c_uint32()
    raise_on_failure(lib.votess_want_of(as_text(names, "want"), bits))
    return bits.value
