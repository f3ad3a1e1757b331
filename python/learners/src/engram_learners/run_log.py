"""What a run writes beside its policy: log.csv, curve.png, result.json; and its processor time."""

import csv
import json
import time

import torch


class Clock:
    """Processor seconds of collecting and learning, without evaluations."""

    def __init__(self):
        # The first optimiser imports most of torch, which does not count.
        torch.optim.Adam([torch.zeros(1, requires_grad=True)])
        self.start, self.out = time.process_time(), 0.0

    def __call__(self):
        return time.process_time() - self.start - self.out

    def exclude(self, function, *arguments):
        begin = time.process_time()
        result = function(*arguments)
        self.out += time.process_time() - begin
        return result


class Log:
    """A row per evaluation: printed, and in FOLDER/log.csv and TensorBoard's files there."""

    def __init__(self, folder):
        self.folder, self.rows, self.board = folder, [], None
        if folder is None:
            return
        folder.mkdir(parents=True, exist_ok=True)
        try:
            from torch.utils.tensorboard import SummaryWriter

            self.board = SummaryWriter(str(folder))
        except ImportError:
            pass  # optional: there are log.csv and the curve

    def add(self, tasks=None, **row):
        """tasks: rates by task of several, which get a column each."""
        for id, one in (tasks or {}).items():
            row |= {f"{id} {name}": rate for name, rate in one.items()}
        self.rows.append(row)
        print(json.dumps(row), flush=True)
        if self.folder is None:
            return
        with (self.folder / "log.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, self.rows[0])
            writer.writeheader()
            writer.writerows(self.rows)
        if self.board is not None:
            for name, value in row.items():
                if isinstance(value, (int, float)):
                    self.board.add_scalar(name, value, row["env_steps"])
            self.board.flush()

    def draw(self, title):
        """FOLDER/curve.png: success and first answers over processor time.

        Of several tasks: the success of each, and the mean.
        """
        if self.folder is None or not self.rows or "success_once" not in self.rows[0]:
            return
        import matplotlib

        matplotlib.use("Agg")
        from matplotlib import pyplot

        of_tasks = [name for name in self.rows[0] if name.endswith(" success_once")]
        figure, axes = pyplot.subplots(figsize=(8, 4.5) if of_tasks else (6, 3.5))
        times = [row["cpu_s"] for row in self.rows]
        for i, name in enumerate(of_tasks or ("success_once", "first_answer_correct")):
            if self.rows[0][name] is not None:
                style = {"linestyle": ("-", "--", ":")[i // 10 % 3]} if of_tasks else {}
                label = name.split()[0]
                axes.plot(times, [row[name] for row in self.rows], label=label, **style)
        if of_tasks:
            mean = [row["success_once"] for row in self.rows]
            axes.plot(times, mean, "k", linewidth=2.5, label="mean")
            axes.set(ylabel="success_once")
        axes.set(title=title, xlabel="processor seconds", ylim=(0, 1.02))
        axes.legend(fontsize=7 if of_tasks else None)
        axes.grid(alpha=0.3)
        figure.tight_layout()
        figure.savefig(self.folder / "curve.png", dpi=120)
        pyplot.close(figure)


def write_result(result, folder):
    """Prints a run's result, and writes FOLDER/result.json if there is a folder."""
    text = json.dumps(result)
    if folder:
        write_whole(folder / "result.json", lambda part: part.write_text(text + "\n"))
    print(text, flush=True)


def write_whole(path, write):
    """Writes a file, by a function of a path, that is whole whenever the run is cut off."""
    part = path.with_suffix(".part")
    write(part)
    part.replace(path)
