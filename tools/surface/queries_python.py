"""Code that follows from the queries, in Python."""

from queries_cpp import GENERATED
from table import WIDTH, wrapped

METHODS = [query for query in GENERATED if query.get("python") != "hand"]
TYPES = {"text": "dict[str, Any]", "arrays": "dict[str, np.ndarray]"}


def mixin(indent):
    """Methods of QueryMixin."""
    result = []
    for query in METHODS:
        kind = TYPES[query["form"]]
        kind = f"list[{kind}]" if query["form"] == "text" else kind
        inner = indent + "    "
        result += ["", f"{indent}def {query['name']}(self) -> {kind}:"]
        result += [f'{inner}"""{query["summary"]}', "", inner + "Returns:"]
        result += wrapped(query["returns"], inner + "    ", inner + "    ")
        result += ["", inner + "Raises:", inner + "    BadStateError: Nothing was reset."]
        result += [inner + '"""', inner + body(query)]
    return [*result[1:], ""]


def body(query):
    call = f"self._batch.{query['name']}"
    if query["form"] == "text":
        return f"return [json.loads({call}(i)) for i in range(self.num_envs)]"
    names = ", ".join(f'"{output["name"]}"' for output in query["outputs"])
    return f"return dict(zip(({names}), {call}()))"


def single(indent):
    """Methods of Env."""
    result = []
    for query in METHODS:
        name, inner = query["name"], indent + "    "
        about = f'{inner}"""{query["single"]} See ``VectorEnv.{name}``."""'
        assert len(about) <= WIDTH, about
        value = f"self.batch.{name}()"
        value = f"{value}[0]" if query["form"] == "text" else f"_first({value})"
        result += ["", f"{indent}def {name}(self) -> {TYPES[query['form']]}:", about]
        result.append(f"{inner}return {value}")
    return [*result[1:], ""]
