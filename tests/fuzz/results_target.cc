// The folder of an interrupted evaluation: settings, results and times of any content.
#include "protocol/evaluation_run.h"
#include "tests/fuzz/input.h"

namespace engram::fuzz {

// The bytes are three files, separated by zeros.
void fuzz_results(Data data) {
  static const Folder folder;
  Input input(data);
  std::string_view rest = input.rest_text();
  for (const char* name : {"settings.json", "RememberColor3-VLA-v0.json", "timing.json"}) {
    const std::size_t end = std::min(rest.find('\0'), rest.size());
    put_file(folder.path() / name, rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  EvaluationSettings settings;
  settings.tasks = {"RememberColor3-VLA-v0"};
  settings.episodes = 2;
  settings.policy = "oracle";
  accepted([&] {
    const ResultFolder results = ResultFolder::open(folder.path());
    if (const auto found = results.settings()) settings = *found;
  });
  accepted([&] {
    const EvaluationRun run(settings, ResultFolder::open(folder.path()));
    (void)run.open_tasks();
    (void)to_text(run.document());
    // Writing what was read takes much longer than reading it.
    if (data.size() % 32 == 0) run.finish("fuzz");
  });
}

}  // namespace engram::fuzz
