#include "protocol/make/make.h"

#include <algorithm>

#include "core/threads/processors.h"
#include "render/make_renderer.h"

namespace engram {
namespace {

// Adds named values; one whose name is there already is replaced. Name: of a value.
template <class T, class Name>
void add_named(std::vector<T>& values, const std::vector<T>& more, Name&& name) {
  for (const T& value : more) {
    const auto found =
        std::ranges::find_if(values, [&](const T& one) { return name(one) == name(value); });
    if (found != values.end()) {
      *found = value;
    } else {
      values.push_back(value);
    }
  }
}

MakeOptions options_of(const TaskShare& share, const MakeOptions& common) {
  MakeOptions options = common;
  options.num_envs = share.num_envs;
  add_named(options.constants, share.constants, [](const auto& one) { return one.first; });
  add_named(options.pins, share.pins, [](const Pin& one) { return one.name; });
  add_named(options.task_options, share.task_options,
            [](const TaskOptionValue& one) { return one.name; });
  return options;
}

}  // namespace

std::unique_ptr<Batch> make(std::string_view id, const MakeOptions& options,
                            RendererFactory renderers) {
  check_ranges(options);
  const BatchOptions& of_batch = options;
  return std::make_unique<Batch>(make_task(id, options.constants, options.max_episode_steps),
                                 of_batch, std::move(renderers));
}

std::unique_ptr<Batch> make(std::string_view id, const MakeOptions& options) {
  return make(id, options, make_renderer);
}

std::unique_ptr<Batch> make(std::string_view id, const BatchOptions& options) {
  return make(id, MakeOptions{options, {}, 0});
}

std::unique_ptr<Batch> make_group(std::span<const TaskShare> tasks, const MakeOptions& options) {
  check_ranges(options);
  MakeOptions common = options;
  if (common.threads == 0) common.threads = std::min(available_processors(), kMaxThreads);
  std::vector<std::unique_ptr<Batch>> batches;
  std::int64_t num_envs = 0;
  for (const TaskShare& share : tasks) {
    batches.push_back(make(share.id, options_of(share, common)));
    num_envs += share.num_envs;
    if (num_envs > kMaxNumEnvs) {
      const std::string most = std::to_string(kMaxNumEnvs);
      throw Error(Error::kInvalidArgument, "environments of all tasks: more than " + most +
                                               " given, at most " + most + " allowed");
    }
  }
  return std::make_unique<Batch>(std::move(batches), common.threads);
}

const char* version() { return ENGRAM_VERSION; }

}  // namespace engram
