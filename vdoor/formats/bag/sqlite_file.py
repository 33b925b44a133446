"""ROS 2 bags in SQLite (.db3), with what a recorder that was killed left in the log beside them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, BinaryIO

import apsw

from vdoor.errors import MapError
from vdoor.formats.bag.budget import Budget
from vdoor.formats.bag.chunked import Topic
from vdoor.formats.bag.sqlite_pages import Pages, connect
from vdoor.formats.source import shown

MAGIC = b"SQLite format 3\0"
STEPS = 10_000
"""Instructions of SQLite between two looks at the budget; one of them counts as a tenth of a record."""
TOPICS = "SELECT id, name, type, serialization_format FROM topics"
TIMES = (
    "SELECT timestamp, id, length(data) FROM messages WHERE topic_id IN ({}) ORDER BY timestamp DESC, id DESC LIMIT 1"
)
ROWS = "SELECT timestamp, id, length(data) FROM messages WHERE topic_id IN ({}) ORDER BY id"
DATA = "SELECT data FROM messages WHERE id = ?"
MOST_TOPICS = 10_000


class SqliteBag:
    """The topics of one file, and the latest message of each."""

    def __init__(self, stream: BinaryIO, size: int, budget: Budget, log: BinaryIO | None = None) -> None:
        self._budget = budget
        self._stopped = False
        self.problems: list[str] = []
        with_log = Pages(stream, size, log)
        if with_log.cut:
            self.problems.append(f"cut short at byte {size}")
        try:
            self._bag, self._files = connect(with_log)
            self._bag.limit(apsw.SQLITE_LIMIT_LENGTH, budget.most_bytes)
            self._bag.set_progress_handler(self._over, STEPS)
            rows = self._rows(TOPICS)
        except apsw.Error as error:
            raise self._refusal(error) from error
        if len(rows) > MOST_TOPICS:
            raise MapError(f"bag: wanted at most {MOST_TOPICS} topics, found {len(rows)}")
        self._ids = {at: Topic(str(name), str(kind), str(encoding)) for at, name, kind, encoding in rows}

    @property
    def topics(self) -> list[Topic]:
        """All topics."""
        return list(self._ids.values())

    def latest(self, topic: str) -> tuple[int, bytes, Topic] | None:
        """Time, data and topic of the latest message, of a file cut short the last whole one; None if there is none."""
        ids = [at for at, found in self._ids.items() if found.name == topic]
        try:
            found = self._whole(ids) if not self.problems else self._last_whole(ids)
        except apsw.Error as error:
            raise self._refusal(error) from error
        return None if found is None else (*found, self._ids[ids[0]])

    def _whole(self, ids: list[Any]) -> tuple[int, bytes] | None:
        """Time and data of the latest message."""
        rows = self._rows(TIMES.format(", ".join("?" * len(ids))), *ids)
        return self._data(*rows[0]) if rows else None

    def _last_whole(self, ids: list[Any]) -> tuple[int, bytes] | None:
        """Time and data of the last message before the place where the file is cut short."""
        found = None
        try:
            for row in self._each(ROWS.format(", ".join("?" * len(ids))), *ids):
                found = self._data(*row)
        except (apsw.IOError, apsw.CorruptError):
            pass
        return found

    def _data(self, time_ns: Any, at: Any, size: Any) -> tuple[int, bytes]:
        """Time and data of a message; raises MapError if it is too large."""
        most = self._budget.most_bytes
        if not isinstance(time_ns, int) or not isinstance(size, int) or size > most:
            raise MapError(
                f"bag: wanted a message of at most {most} bytes (--max-cells raises it), found one of {size}"
            )
        data = [data for (data,) in self._rows(DATA, at)]
        if not data or not isinstance(data[0], bytes):
            raise MapError("bag: wanted an intact SQLite database, found a message without data")
        return time_ns, data[0]

    def close(self) -> None:
        """Close the connection; the stream stays open."""
        self._bag.close()

    def _rows(self, query: str, *values: Any) -> list[tuple[Any, ...]]:
        return list(self._each(query, *values))

    def _each(self, query: str, *values: Any) -> Iterator[tuple[Any, ...]]:
        """The rows of a query; raises MapError for text that is none."""
        try:
            yield from self._bag.execute(query, values)
        except UnicodeDecodeError as error:
            raise MapError(f"bag: wanted an intact SQLite database, found text that is not UTF-8 ({error})") from error

    def _over(self) -> bool:
        """Whether the query takes more work than the budget allows."""
        try:
            self._budget.take_records(STEPS // 10)
        except MapError:
            self._stopped = True
        return self._stopped

    def _refusal(self, error: apsw.Error) -> MapError:
        """What SQLite's error means."""
        if self._stopped:
            return MapError("bag: wanted a query that fits the file's size, found that it takes far more work")
        if isinstance(error, apsw.TooBigError):
            return MapError(
                f"bag: wanted a message of at most {self._budget.most_bytes} bytes (--max-cells raises it), found more"
            )
        if isinstance(error, apsw.SQLError):
            return MapError(f"bag: wanted a ROS 2 bag's tables, found another SQLite database ({shown(str(error))})")
        return MapError(f"bag: wanted an intact SQLite database, found a damaged one ({shown(str(error))})")
