"""The command `engram servers check`."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

import engram
from engram._distribution import install_command
from engram.servers.options import add_arguments, given_arguments


def parser() -> argparse.ArgumentParser:
    """Options of the command."""
    result = argparse.ArgumentParser(
        prog="engram servers check",
        description="Asks a policy server some questions, and names likely mistakes.",
        epilog="Exit code: 0 no likely mistake, 1 one or more, 2 usage error.",
    )
    add = result.add_argument
    add("url", metavar="URL", help="openpi|gr00t|act|vla-eval://HOST:PORT")
    add("ids", nargs="*", metavar="ID", help="tasks that the policy was trained for")
    add("--seed", type=int, default=4242424242, help="of the first episode")
    add("--control-mode", metavar="MODE", help="as of eval; default: the tasks' own")
    add("--tell-episodes", action="store_true", help="as of eval")
    add("--policy-timeout", type=float, default=300.0, metavar="SECONDS", help="of an answer")
    add("--json", action="store_true", help="prints the report as JSON")
    add_arguments(result)
    return result


def check_server(words: list[str]) -> int:
    """Runs the check; returns the exit code."""
    options = parser().parse_args(words)
    try:
        report = _checked(options)
    except ModuleNotFoundError as error:
        what = install_command("servers")
        print(f"engram servers: {error}; `{what}` installs what it needs", file=sys.stderr)
        return 1
    except engram.Error as error:
        print(f"engram servers: {error}", file=sys.stderr)
        usage = (engram.InvalidArgumentError, engram.UnknownIdError)
        return 2 if isinstance(error, usage) else 1
    print(json.dumps(report, indent=2) if options.json else _text(report))
    return int(any(finding["mistake"] for finding in report["findings"]))


def _checked(options: argparse.Namespace) -> dict[str, Any]:
    from engram.servers.checking.run import check

    return check(
        options.url,
        **({"ids": options.ids} if options.ids else {}),
        seed=options.seed,
        control_mode=options.control_mode,
        tell_episodes=options.tell_episodes,
        timeout=options.policy_timeout,
        **given_arguments(options),
    )


def _text(report: dict[str, Any]) -> str:
    lines = [f"{report['server']}: {report['questions']} questions"]
    if report["questions"]:
        lines += [f"  actions of an answer: {report['chunk']}", "  what each number does here:"]
        lines += [f"    {line}" for line in report["motions"]]
        lines += ["  the answers, beside the oracle's actions:"]
        lines += [f"    {i} {_number(number)}" for i, number in enumerate(report["numbers"])]
        lines += ["  change of an answer when an input changes:"]
        lines += [f"    {name}: {far:.3g}" for name, far in report["influence"].items()]
        lines += [f"  earlier frames matter: {'yes' if report['remembers'] else 'no'}"]
    for finding in report["findings"]:
        kind = "mistake" if finding["mistake"] else "note"
        end = f" ({finding['remedy']})" if finding["remedy"] else ""
        lines.append(f"{kind}: {finding['what']}: {finding['likely']}{end}")
    if not any(finding["mistake"] for finding in report["findings"]):
        lines.append("no likely mistake")
    return "\n".join(lines)


def _number(number: dict[str, Any]) -> str:
    words = f"{number['name']}: {number['low']:.3g} to {number['high']:.3g}"
    if number["correlation"] is not None:
        words += f"; correlation {number['correlation']:.2f} with {number['like']}"
    if number["scale"] is not None:
        words += f", scale {number['scale']:.2g}"
    return words
