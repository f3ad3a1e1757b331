#include "protocol/eval/results/result_files.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <thread>

#include "protocol/eval/results/result_check.h"
#include "protocol/eval/results/result_tables.h"
#include "protocol/eval/results/success_rates.h"
#include "protocol/eval/run/mean.h"
#include "protocol/io/chained_hash.h"
#include "protocol/io/files.h"
#include "protocol/io/json_checksum.h"
#include "protocol/io/json_values.h"
#include "protocol/make/baseline_scores.h"
#include "protocol/make/definitions.h"
#include "protocol/make/perturbations_document.h"
#include "protocol/make/physics_keys.h"
#include "protocol/make/variants.h"
#include "protocol/parallel/shard_set.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSettingsFile = "settings.json";
constexpr const char* kSummaryFile = "summary.json";
constexpr const char* kSummaryTable = "summary.csv";
constexpr const char* kEpisodeTable = "episodes.csv";
constexpr const char* kTimingFile = "timing.json";
constexpr const char* kReportFile = "report.html";
constexpr const char* kSampleFolder = "samples";
// Keys that only some runs have.
constexpr const char* kSealed = "sealed";
constexpr const char* kPerturbations = "perturbations";
constexpr const char* kDefinition = "definition";

// The spelling of result files; tasks outside the benchmark's splits are "Custom".
std::string title(Split split) {
  switch (split) {
    case Split::kShort:
      return "Short";
    case Split::kMedium:
      return "Medium";
    case Split::kLong:
      return "Long";
    case Split::kRl:
      return "RL";
    case Split::kExtended:
      break;
  }
  return "Custom";
}

std::string local_time() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm local{};
  ::localtime_r(&now, &local);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d_%H-%M-%S", &local);
  return text;
}

// Keys of a task document with the settings: the same in all documents of a run.
constexpr const char* kProtocolKeys[] = {
    "start_seed", "n_episodes", "control_mode", "obs_mode", "version", "rules", "model", kSealed,
    kPerturbations, kMujocoVersionKey,
    // begin generated: keys (tools/surface, from api/surface.toml)
    "tell_episodes", "repeat", "policy_seed", "latency_steps", "joint_proprio", "choices",
    "choices_stride", "physics",
    // end generated
};

Json start_seed_document(const EvaluationSettings& settings) {
  return settings.tells_seeds() ? Json(settings.start_seed) : Json();
}

Json seeds_document(const EvaluationSettings& settings) {
  if (!settings.tells_seeds()) return {};
  JsonList seeds;
  for (int i = 0; i < settings.all_episodes(); ++i) {
    seeds.emplace_back(settings.start_seed + static_cast<std::uint64_t>(i % settings.episodes));
  }
  return seeds;
}

// Throws Error unless a result was asked for in the same way as this run's.
void check_protocol(const fs::path& file, const Json& task, const Json& expected) {
  for (const char* key : kProtocolKeys) {
    const Json found = value_or_null(task, key);
    const Json asked = value_or_null(expected, key);
    if (found == asked) continue;
    throw Error(Error::kInvalidArgument, "'" + file.string() + "' has " + key + " " +
                                             to_line(found) + ", this run " + to_line(asked) +
                                             "; one folder holds results of one protocol");
  }
}

// True if a run with these settings writes the genuine document so. A run that was killed while it
// opened its results has written some of them opened.
bool is_written(const Json& task, const Json& genuine, const EvaluationSettings& settings) {
  if (task == genuine) return true;
  if (settings.tells_seeds()) return false;
  EvaluationSettings revealed = settings;
  revealed.revealed = true;
  return task == revealed_document(genuine, revealed);
}

// Throws Error unless a result is of the task as it is now.
void check_variant(const fs::path& file, const Json& task, const Json& now) {
  const Json then = value_or_null(task, "variant");
  if (then == now) return;
  throw Error(Error::kInvalidArgument, "'" + file.string() + "' has variant " + to_line(then) +
                                           ", this run " + to_line(now) +
                                           "; one folder holds results of one protocol");
}

Json digests_document(const std::vector<EpisodeDigests>& digests) {
  if (digests.empty()) return {};
  JsonTable document;
  for (const auto& [key, field] : kDigestKeys) {
    JsonList texts;
    for (const EpisodeDigests& one : digests) texts.emplace_back(hash_text(one.*field));
    document.emplace_back(key, std::move(texts));
  }
  return document;
}

// Adds the settings that are not the default.
void add_settings(const EvaluationSettings& settings, JsonTable& keys) {
  const EvaluationSettings usual;
  const bool rounds = settings.repeat != usual.repeat || settings.policy_seed != usual.policy_seed;
  const auto add = [&keys](const char* key, bool written, Json value) {
    if (written) keys.emplace_back(key, std::move(value));
  };
  // begin generated: first_keys
  add("tell_episodes", settings.tell_episodes != usual.tell_episodes, settings.tell_episodes);
  add("joint_proprio", settings.joint_proprio != usual.joint_proprio, settings.joint_proprio);
  add("repeat", rounds, settings.repeat);
  add("policy_seed", rounds, settings.policy_seed);
  add("latency_steps", settings.latency != usual.latency, settings.latency);
  // end generated
  const Json perturbations = perturbations_document(settings.perturbations);
  add(kPerturbations, !is_null(perturbations), perturbations);
  // begin generated: further_keys
  add("choices", settings.choices != usual.choices, settings.choices);
  add("choices_stride", settings.choices_stride != usual.choices_stride, settings.choices_stride);
  add("physics", settings.physics != usual.physics, name_of(settings.physics));
  // end generated
  add(kMujocoVersionKey, settings.physics == Physics::kMujoco, mujoco_version_of(settings.physics));
  add(kSealed, settings.commitment.has_value(), settings.commitment_document());
}

// A value of each element; null without elements.
template <class T, class Value>
Json column(const std::vector<T>& elements, Value&& value) {
  if (elements.empty()) return {};
  JsonList values;
  for (const T& element : elements) values.push_back(value(element));
  return values;
}

// Null for tasks without baseline scores, which are those of the tasks as they are by default, for
// policies that act, and at once.
Json memory_score_of(const TaskResult& result, const EvaluationSettings& settings) {
  const bool usual = settings.rules == Rules::kReference && settings.task_options.empty() &&
                     settings.constants.empty() && settings.latency == 0 && !settings.choices &&
                     settings.physics == Physics::kEngram &&
                     is_null(perturbations_document(settings.perturbations));
  const BaselineScores* baseline = usual ? find_baseline_scores(result.entry->id) : nullptr;
  if (baseline == nullptr) return {};
  const std::optional<double> score = memory_score(*baseline, result.success_rate());
  return score ? Json(*score) : Json();
}

// Keys of engram's own, behind the protocol's. Null without a value.
JsonTable own_keys(const TaskResult& result, const EvaluationSettings& settings) {
  const bool answers = !result.answers.empty();
  const auto first = [](const Answer& one) { return one.given != 0 ? Json(one.first) : Json(); };
  const auto correct = [](const Answer& one) { return Json(one.correct != 0); };
  const auto done = [](const Completion& one) { return Json(one.done); };
  const auto subtasks = [](const Completion& one) { return Json(one.subtasks); };
  JsonTable keys = {
      {"version", version()},
      {"rules", name_of(settings.rules)},
      {"chance", result.chance},
      {"first_answers", column(result.answers, first)},
      {"first_answers_correct", column(result.answers, correct)},
      {"first_answer_correct", answers ? Json(result.answer_rate()) : Json()},
      {"answer_chance", answers ? Json(result.answer_chance) : Json()},
      {"memory_score", memory_score_of(result, settings)},
      {"subtasks_done", column(result.completions, done)},
      {"subtasks", column(result.completions, subtasks)},
      {"completion_rate", result.completions.empty() ? Json() : Json(result.completion_rate())},
      {"sr_interval",
       to_document(wilson_interval(result.success_rate(),
                                   effective_episodes(result.successes, settings.repeat)))},
      {"digests", digests_document(result.digests)}};
  add_settings(settings, keys);
  Json variant = variant_document(*result.entry, settings.constants);
  if (!is_null(variant)) keys.emplace_back("variant", std::move(variant));
  Json definition = definition_of(*result.entry);
  if (!is_null(definition)) keys.emplace_back(kDefinition, std::move(definition));
  return keys;
}

}  // namespace

// --- documents ---

Json model_document(const EvaluationSettings& settings) {
  JsonTable config = {{"library", "engram"}, {"version", version()}};
  if (!is_null(settings.policy_config)) config = table(settings.policy_config);
  if (!settings.task_options.empty()) {
    config.emplace_back("task_options",
                        JsonTable(settings.task_options.begin(), settings.task_options.end()));
  }
  return JsonTable{{"name", settings.policy}, {"config", std::move(config)}};
}

Json task_document(const TaskResult& result, const EvaluationSettings& settings) {
  const RegistryEntry& entry = *result.entry;
  JsonTable document{{"env_id", entry.id},
                     {"split", title(entry.split)},
                     {"memory_type", entry.memory_type},
                     {"start_seed", start_seed_document(settings)},
                     {"n_episodes", settings.all_episodes()},
                     {"successes", to_list(result.successes)},
                     {"returns", to_list(result.returns)},
                     {"sr", result.success_rate()},
                     {"mean_return", result.mean_return()},
                     {"benchmark_commit", nullptr},
                     {"control_mode", name_of(settings.control_mode)},
                     {"obs_mode", name_of(settings.obs_mode)},
                     {"wrapper_chain", "apply_mikasa_vla_wrappers(include_overlays=False)"},
                     {"action_chunk_size", result.chunk_size},
                     {"model", model_document(settings)},
                     {"episode_lengths", to_list(result.lengths)},
                     {"episode_seeds", seeds_document(settings)}};
  JsonTable own = own_keys(result, settings);
  std::ranges::move(own, std::back_inserter(document));
  add_checksum(document);
  return document;
}

Json revealed_document(const Json& task, const EvaluationSettings& revealed) {
  JsonTable document = table(task);
  document.pop_back();  // the checksum
  for (auto& [key, value] : document) {
    if (key == "start_seed") value = start_seed_document(revealed);
    if (key == "episode_seeds") value = seeds_document(revealed);
    if (key == kSealed) value = revealed.commitment_document();
  }
  add_checksum(document);
  return document;
}

Json summary_document(const JsonList& tasks) {
  std::string split;
  std::vector<double> rates;
  std::map<std::string, std::vector<double>> rates_of_type;  // sorted by name
  JsonList ids;
  JsonTable per_task_rate;
  JsonTable per_task_return;
  JsonTable per_task_interval;
  for (const Json& task : tasks) {
    const std::string& id = text(part(task, "env_id"));
    const std::string& own = text(part(task, "split"));
    split = split.empty() || split == own ? own : "Custom";
    rates.push_back(number(part(task, "sr")));
    rates_of_type[text(part(task, "memory_type"))].push_back(rates.back());
    ids.emplace_back(id);
    per_task_rate.emplace_back(id, rates.back());
    per_task_return.emplace_back(id, part(task, "mean_return"));
    per_task_interval.emplace_back(id, to_document(success_rate(task).interval));
  }
  JsonTable splits;
  for (const auto& [name, group] : success_rates_by("split", tasks)) {
    splits.emplace_back(name, JsonTable{{"sr", group.rate},
                                        {"sr_interval", to_document(group.interval)},
                                        {"n_tasks", group.tasks},
                                        {"n_episodes", group.episodes}});
  }
  JsonTable per_type;
  for (const auto& [type, values] : rates_of_type) per_type.emplace_back(type, mean(values));
  return JsonTable{{"split", split},
                   {"sr_split", mean(rates)},
                   {"sr_per_memory_type", std::move(per_type)},
                   {"tasks", std::move(ids)},
                   {"per_task_sr", std::move(per_task_rate)},
                   {"per_task_mean_return", std::move(per_task_return)},
                   {"sr_interval", to_document(mean_success_rate(tasks).interval)},
                   {"splits", std::move(splits)},
                   {"per_task_sr_interval", std::move(per_task_interval)}};
}

std::string common_split(const std::vector<std::string>& ids) {
  std::set<std::string_view> splits;
  for (const std::string& id : ids) splits.insert(split_name(require_entry(id).split));
  return splits.size() == 1 ? std::string(*splits.begin()) : "all";
}

// --- the folder ---

ResultFolder ResultFolder::create(const fs::path& output, const EvaluationSettings& settings) {
  const fs::path parent = output / common_split(settings.tasks);
  require_writable_folder(parent);
  remove_temporary_files(parent.string());  // of a run that was killed before it had a folder
  while (true) {
    const fs::path folder = parent / local_time();
    std::error_code error;
    if (fs::create_directory(folder, error)) return ResultFolder(folder);
    if (error) {
      throw Error(Error::kIo,
                  "folder '" + folder.string() + "' cannot be made: " + error.message());
    }
    // Another run began in this very second.
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

ResultFolder ResultFolder::of_shard(const fs::path& output, const Shard& shard) {
  const fs::path folder = output / shard_folder(shard);
  require_writable_folder(folder);
  return ResultFolder(folder);
}

ResultFolder ResultFolder::open(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    throw Error(Error::kIo, "folder '" + folder.string() + "' does not exist; nothing to resume");
  }
  ResultFolder opened(folder);
  require_writable_folder(folder);
  remove_temporary_files(opened.files().subfolder(kSampleFolder).path().string());
  return opened;
}

ResultFolder::ResultFolder(fs::path path)
    : path_(std::move(path)), lock_(std::make_shared<const FolderLock>(path_)) {}

std::optional<EvaluationSettings> settings_in(const OpenFolder& folder) {
  const std::optional<std::string> text = folder.read_file(kSettingsFile);
  if (!text) return std::nullopt;
  return EvaluationSettings::of(parse_json(*text).value_or(Json()), folder.path() / kSettingsFile);
}

std::map<std::string, Json> ResultFolder::finished(const EvaluationSettings& settings) const {
  TaskResult none;
  none.entry = &registry().front();
  const Json expected = task_document(none, settings);
  std::map<std::string, Json> tasks;
  for (const RegistryEntry* entry : all_entries()) {
    const std::string id(entry->id);
    const fs::path file = path_ / (id + ".json");
    const std::optional<std::string> text = files().read_file(id + ".json");
    if (!text) continue;
    const std::optional<Json> task = parse_json(*text);
    const std::optional<TaskResult> result = task ? parse_result(*task, *entry) : std::nullopt;
    if (!result) continue;
    Json genuine = task_document(*result, settings);
    if (follows_protocol(*result, settings) && is_written(*task, genuine, settings)) {
      tasks.emplace(id, std::move(genuine));
      continue;
    }
    check_protocol(file, *task, expected);
    check_variant(file, *task, variant_document(*entry, settings.constants));
    require_same_definition(id, value_or_null(*task, kDefinition), "'" + file.string() + "'",
                            definition_of(*entry));
    // Edited files count as damaged, too.
  }
  return tasks;
}

void ResultFolder::begin(const EvaluationSettings& settings) const {
  files().write_file(kSettingsFile, to_text(settings.document()));
}

void ResultFolder::write_task(const Json& task) const {
  files().write_file(text(part(task, "env_id")) + ".json", to_text(task));
}

void ResultFolder::write_summary(const JsonList& tasks) const {
  files().write_file(kSummaryFile, to_text(summary_document(tasks)));
  files().write_file(kSummaryTable, summary_csv(tasks));
}

void ResultFolder::write_episodes(const JsonList& tasks) const {
  files().write_file(kEpisodeTable, episodes_csv(tasks));
}

// --- for the report ---

void ResultFolder::add_timing(const std::string& id, double thread_seconds) const {
  std::map<std::string, double> seconds = timing();
  seconds[id] = thread_seconds;
  files().write_file(kTimingFile, to_text(JsonTable(seconds.begin(), seconds.end())));
}

std::map<std::string, double> ResultFolder::timing() const {
  std::map<std::string, double> seconds;
  const std::optional<std::string> text = files().read_file(kTimingFile);
  const std::optional<Json> document = text ? parse_json(*text) : std::nullopt;
  const auto* times = document ? std::get_if<JsonTable>(&document->value) : nullptr;
  if (times == nullptr) return seconds;
  for (const auto& [id, value] : *times) {
    if (is_number(value)) seconds[id] = number(value);
  }
  return seconds;
}

void ResultFolder::write_sample(const std::string& id, const Bytes& png) const {
  if (png.empty()) return;
  files().subfolder(kSampleFolder).write_file(id + ".png", std::span<const std::byte>(png));
}

std::map<std::string, Bytes> ResultFolder::samples() const {
  std::map<std::string, Bytes> samples;
  const OpenFolder folder = files().subfolder(kSampleFolder);
  for (const RegistryEntry* entry : all_entries()) {
    const std::string id(entry->id);
    const std::optional<std::string> text = folder.read_file(id + ".png");
    if (!text) continue;
    const auto bytes = std::as_bytes(std::span(text->data(), text->size()));
    samples[id].assign(bytes.begin(), bytes.end());
  }
  return samples;
}

void ResultFolder::write_report(const std::string& html) const {
  files().write_file(kReportFile, html);
}

}  // namespace engram
