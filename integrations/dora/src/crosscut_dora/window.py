"""Messages that arrive once and in order over a way that loses some: what is not acknowledged is sent again.

Each message has a number, and each time that it is sent a number of its own, its transmission. The receiver acknowledges
both. Messages do not overtake each other on the way, so one that was sent before another that has arrived is lost, and is sent
again at once. Where nothing arrives any more, the oldest is sent again after a while.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Generic, TypeVar

Message = TypeVar("Message")

PATIENCE_S = 0.5
"""After so long without an acknowledgement, the oldest message is sent again; then after twice as long, and so on."""

MOST_PATIENCE_S = 4.0


class Window(Generic[Message]):
    """The sender's end: at most ``size`` messages from the oldest one that is not acknowledged."""

    def __init__(
        self, send: Callable[[int, int, Message], None], size: int, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.resent = 0
        self._send, self._size, self._clock = send, size, clock
        self._number = self._transmission = 0
        self._waiting: dict[int, tuple[int, Message]] = {}  # in the order of their transmissions
        self._heard_at = self._due_at = self._wait_s = 0.0
        self._hear()

    def __len__(self) -> int:
        """How many messages are not acknowledged."""
        return len(self._waiting)

    @property
    def has_room(self) -> bool:
        return self._number < min(self._waiting, default=self._number) + self._size

    @property
    def silent_s(self) -> float:
        """How long nothing was acknowledged, although something waits for it."""
        return self._clock() - self._heard_at if self._waiting else 0.0

    @property
    def patience_s(self) -> float:
        """How long to wait for an acknowledgement before :meth:`repeat`."""
        return max(0.0, self._due_at - self._clock())

    def add(self, message: Message) -> None:
        if not self._waiting:
            self._hear()
        self._transmit(self._number, message)
        self._number += 1

    def acknowledge(self, number: int, transmission: int) -> None:
        self._hear()
        self._waiting.pop(number, None)
        overtaken = [number for number, (sent, _) in self._waiting.items() if sent < transmission]
        for lost in overtaken:
            self._repeat(lost)

    def repeat(self) -> None:
        """Sends the oldest message again, if nothing was heard for too long."""
        if self._waiting and self.patience_s == 0.0:
            self._wait_s = min(2.0 * self._wait_s, MOST_PATIENCE_S)
            self._due_at = self._clock() + self._wait_s
            self._repeat(min(self._waiting))

    def _hear(self) -> None:
        self._heard_at, self._wait_s = self._clock(), PATIENCE_S
        self._due_at = self._heard_at + self._wait_s

    def _repeat(self, number: int) -> None:
        self.resent += 1
        self._transmit(number, self._waiting.pop(number)[1])

    def _transmit(self, number: int, message: Message) -> None:
        self._waiting[number] = (self._transmission, message)
        self._send(number, self._transmission, message)
        self._transmission += 1


class Order(Generic[Message]):
    """The receiver's end."""

    def __init__(self) -> None:
        self._next = 0
        self._early: dict[int, Message] = {}

    def take(self, number: int, message: Message) -> list[Message]:
        """The messages that are next in order, now that this one is there."""
        if number >= self._next:
            self._early[number] = message
        ready = []
        while self._next in self._early:
            ready.append(self._early.pop(self._next))
            self._next += 1
        return ready
