"""Progress of an evaluation in a terminal, as a live table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from engram.errors import UnavailableError

__all__ = ["RichBenchmarkUI"]


class RichBenchmarkUI:
    """Shows the tasks that are done and the one that runs; needs rich.

        with RichBenchmarkUI(tasks, config.n_episodes) as ui:
            evaluate_benchmark(
                tasks, policy, config, task_start_callback=ui.on_task_start,
                episode_callback=ui.on_episode_done, task_done_callback=ui.on_task_done,
            )

    Args:
        tasks: The evaluated tasks.
        n_episodes: Episodes of each.
        initial_results: Results of finished tasks.
    """

    def __init__(
        self,
        tasks: Sequence[Any],
        n_episodes: int,
        *,
        initial_results: list[dict[str, Any]] | None = None,
    ) -> None:
        try:
            import rich.live  # noqa: F401
        except ImportError:
            raise UnavailableError("RichBenchmarkUI needs rich: pip install rich") from None
        self._tasks = list(tasks)
        self._episodes = n_episodes
        self._done = list(initial_results or [])
        self._current: Any = None
        self._successes: list[bool] = []
        self._returns: list[float] = []
        self._live: Any = None

    def __enter__(self) -> RichBenchmarkUI:
        from rich.live import Live

        self._live = Live(self._table(), refresh_per_second=8)
        self._live.__enter__()
        return self

    def __exit__(self, *error: Any) -> None:
        self._live.__exit__(*error)

    def on_task_start(self, task_idx: int, task: Any) -> None:
        """A task begins."""
        self._current, self._successes, self._returns = task, [], []
        self._show()

    def on_episode_done(self, episode_idx: int, result: Any) -> None:
        """An episode of it has ended."""
        self._successes.append(result.success_once)
        self._returns.append(result.episode_return)
        self._show()

    def on_task_done(self, task_idx: int, result_dict: dict[str, Any]) -> None:
        """All of them have."""
        self._done.append(result_dict)
        self._current = None
        self._show()

    def _show(self) -> None:
        if self._live is not None:
            self._live.update(self._table())

    def _table(self) -> Any:
        from rich.table import Table

        table = Table(title=f"{len(self._done)} of {len(self._tasks)} tasks", expand=True)
        for name in ("Task", "Split", "Memory type", "Episodes", "Success", "Return"):
            table.add_column(name, justify="left" if name == "Task" else "right")
        for done in self._done:
            table.add_row(
                done["env_id"],
                done["split"],
                done["memory_type"],
                str(done["n_episodes"]),
                f"{done['sr']:.1%}",
                f"{done['mean_return']:.4f}",
            )
        count = len(self._successes)
        if self._current is not None and count:
            table.add_row(
                self._current.env_id,
                self._current.split.title(),
                self._current.memory_type,
                f"{count}/{self._episodes}",
                f"{sum(self._successes) / count:.1%}",
                f"{sum(self._returns) / count:.4f}",
            )
        return table
