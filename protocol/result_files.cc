#include "protocol/result_files.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <fstream>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <set>
#include <thread>

#include "protocol/files.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSettingsFile = "settings.json";
constexpr const char* kSummaryFile = "summary.json";
constexpr const char* kTimingFile = "timing.json";
constexpr const char* kReportFile = "report.html";
constexpr const char* kSampleFolder = "samples";

// As result files spell it; tasks outside the benchmark's splits are "Custom".
std::string title(Split split) {
  switch (split) {
    case Split::kShort:
      return "Short";
    case Split::kMedium:
      return "Medium";
    case Split::kLong:
      return "Long";
    case Split::kExtended:
      break;
  }
  return "Custom";
}

double mean(const std::vector<double>& values) {
  if (values.empty()) return 0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::optional<std::string> content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(file), {});
}

std::string local_time() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm local{};
  ::localtime_r(&now, &local);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d_%H-%M-%S", &local);
  return text;
}

// A number that may not be negative, have a fraction or be larger than `most`: conversions would
// make it some other one.
std::uint64_t whole_number(const Json& document, const char* key, std::uint64_t most,
                           const fs::path& file) {
  const Json& value = document.at(key);
  if (value.is_number_unsigned() && value.get<std::uint64_t>() <= most) {
    return value.get<std::uint64_t>();
  }
  throw Error(Error::kIo, "'" + file.string() + "' has " + key + " " + value.dump(-1, ' ', true) +
                              ", a whole number up to " + std::to_string(most) + " needed");
}

// The keys of a task document that hold what was asked for, and so are the same in all of a run.
Json protocol_part(const Json& task) {
  Json part = Json::object();
  for (const char* key : {"start_seed", "n_episodes", "control_mode", "obs_mode", "model"}) {
    part[key] = task.at(key);
  }
  return part;
}

bool is_list_of(const Json& list, std::size_t count, bool (*fits)(const Json&)) {
  return list.is_array() && list.size() == count && std::all_of(list.begin(), list.end(), fits);
}

// Whether a document is a whole result of the task: everything that is read of one later is there,
// and of its type.
bool is_result(const Json& task, const std::string& id) {
  const auto is_count = [](const Json& value) { return value.is_number_unsigned(); };
  const auto is_number = [](const Json& value) { return value.is_number(); };
  const auto is_truth = [](const Json& value) { return value.is_boolean(); };
  try {
    if (task.at("env_id") != id || !is_count(task.at("n_episodes"))) return false;
    const auto episodes = task.at("n_episodes").get<std::size_t>();
    if (!is_list_of(task.at("successes"), episodes, is_truth) ||
        !is_list_of(task.at("returns"), episodes, is_number) ||
        !is_list_of(task.at("episode_lengths"), episodes, is_count) ||
        !is_list_of(task.at("episode_seeds"), episodes, is_count)) {
      return false;
    }
    const auto successes = task.at("successes").get<std::vector<bool>>();
    const auto count = std::count(successes.begin(), successes.end(), true);
    const double rate =
        successes.empty() ? 0 : static_cast<double>(count) / static_cast<double>(episodes);
    (void)protocol_part(task);
    return is_number(task.at("sr")) && task.at("sr").get<double>() == rate &&
           is_number(task.at("mean_return")) && task.at("split").is_string() &&
           task.at("memory_type").is_string() && is_count(task.at("action_chunk_size")) &&
           (!task.contains("chance") || is_number(task.at("chance")));
  } catch (const Json::exception&) {
    return false;
  }
}

Json model_document(const EvaluationSettings& settings) {
  Json config = {{"library", "engram"}, {"version", version()}};
  if (!settings.policy_config.is_null()) config = settings.policy_config;
  if (!settings.task_options.empty()) config["task_options"] = settings.task_options;
  return {{"name", settings.policy}, {"config", config}};
}

}  // namespace

// --- documents ---

Json EvaluationSettings::document() const {
  return {{"tasks", tasks},
          {"n_episodes", episodes},
          {"start_seed", start_seed},
          {"obs_mode", obs_mode},
          {"renderer", renderer},
          {"policy", policy},
          {"policy_config", policy_config},
          {"task_options", task_options}};
}

EvaluationSettings EvaluationSettings::of(const Json& document, const fs::path& file) {
  try {
    EvaluationSettings settings;
    document.at("tasks").get_to(settings.tasks);
    for (const std::string& id : settings.tasks) (void)require_entry(id);
    settings.episodes = static_cast<int>(
        whole_number(document, "n_episodes", std::numeric_limits<int>::max(), file));
    settings.start_seed =
        whole_number(document, "start_seed", std::numeric_limits<std::uint64_t>::max(), file);
    document.at("obs_mode").get_to(settings.obs_mode);
    document.at("renderer").get_to(settings.renderer);
    document.at("policy").get_to(settings.policy);
    settings.policy_config = document.at("policy_config");
    document.at("task_options").get_to(settings.task_options);
    return settings;
  } catch (const Json::exception& error) {
    throw Error(Error::kIo, "'" + file.string() + "' is not what an evaluation wrote (" +
                                error.what() + "); remove it to give the settings anew");
  }
}

Json task_document(const TaskResult& result, const EvaluationSettings& settings) {
  const RegistryEntry& entry = *result.entry;
  return {{"env_id", entry.id},
          {"split", title(entry.split)},
          {"memory_type", entry.memory_type},
          {"start_seed", settings.start_seed},
          {"n_episodes", settings.episodes},
          {"successes", result.successes},
          {"returns", result.returns},
          {"sr", result.success_rate()},
          {"mean_return", result.mean_return()},
          {"chance", result.chance},
          {"benchmark_commit", nullptr},
          {"control_mode", control_mode_name(ControlMode::kPdEeDeltaPose)},
          {"obs_mode", settings.obs_mode},
          {"wrapper_chain", "apply_mikasa_vla_wrappers(include_overlays=False)"},
          {"action_chunk_size", result.chunk_size},
          {"model", model_document(settings)},
          {"episode_lengths", result.lengths},
          {"episode_seeds", result.seeds}};
}

Json summary_document(const std::vector<Json>& tasks) {
  std::string split;
  std::vector<double> rates;
  std::map<std::string, std::vector<double>> rates_of_type;  // sorted by name
  Json ids = Json::array();
  Json per_task_rate = Json::object();
  Json per_task_return = Json::object();
  for (const Json& task : tasks) {
    const auto id = task.at("env_id").get<std::string>();
    const auto own = task.at("split").get<std::string>();
    split = split.empty() || split == own ? own : "Custom";
    rates.push_back(task.at("sr").get<double>());
    rates_of_type[task.at("memory_type").get<std::string>()].push_back(rates.back());
    ids.push_back(id);
    per_task_rate[id] = rates.back();
    per_task_return[id] = task.at("mean_return");
  }
  Json per_type = Json::object();
  for (const auto& [type, values] : rates_of_type) per_type[type] = mean(values);
  return {
      {"split", split}, {"sr_split", mean(rates)},      {"sr_per_memory_type", per_type},
      {"tasks", ids},   {"per_task_sr", per_task_rate}, {"per_task_mean_return", per_task_return}};
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
  remove_temporary_files(parent);  // of a run that was killed before it had a folder
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

ResultFolder ResultFolder::open(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    throw Error(Error::kIo, "folder '" + folder.string() + "' does not exist; nothing to resume");
  }
  require_writable_folder(folder);
  remove_temporary_files(folder);
  return ResultFolder(folder);
}

std::optional<EvaluationSettings> ResultFolder::settings() const {
  const fs::path file = path_ / kSettingsFile;
  const std::optional<std::string> text = content(file);
  if (!text) return std::nullopt;
  return EvaluationSettings::of(parse_json(*text), file);
}

std::map<std::string, Json> ResultFolder::finished(const EvaluationSettings& settings) const {
  TaskResult none;
  none.entry = &registry().front();
  const Json expected = protocol_part(task_document(none, settings));
  std::map<std::string, Json> tasks;
  for (const RegistryEntry& entry : registry()) {
    const std::string id(entry.id);
    const fs::path file = path_ / (id + ".json");
    const std::optional<std::string> text = content(file);
    if (!text) continue;
    Json task = parse_json(*text);
    if (!is_result(task, id)) continue;
    const Json part = protocol_part(task);
    for (const auto& [key, value] : expected.items()) {
      if (part.at(key) == value) continue;
      throw Error(Error::kInvalidArgument, "'" + file.string() + "' has " + key + " " +
                                               part.at(key).dump() + ", this run " + value.dump() +
                                               "; one folder holds results of one protocol");
    }
    tasks.emplace(id, std::move(task));
  }
  return tasks;
}

void ResultFolder::begin(const EvaluationSettings& settings) const {
  write_file(path_ / kSettingsFile, to_text(settings.document()));
}

void ResultFolder::write_task(const Json& task) const {
  write_file(path_ / (task.at("env_id").get<std::string>() + ".json"), to_text(task));
}

void ResultFolder::write_summary(const std::vector<Json>& tasks) const {
  write_file(path_ / kSummaryFile, to_text(summary_document(tasks)));
}

// --- for the report ---

void ResultFolder::add_timing(const std::string& id, double thread_seconds) const {
  std::map<std::string, double> seconds = timing();
  seconds[id] = thread_seconds;
  write_file(path_ / kTimingFile, to_text(Json(seconds)));
}

std::map<std::string, double> ResultFolder::timing() const {
  std::map<std::string, double> seconds;
  const std::optional<std::string> text = content(path_ / kTimingFile);
  const Json document = text ? parse_json(*text) : Json();
  if (!document.is_object()) return seconds;
  for (const auto& [id, value] : document.items()) {
    if (value.is_number()) seconds[id] = value.get<double>();
  }
  return seconds;
}

void ResultFolder::write_sample(const std::string& id, const Bytes& png) const {
  if (png.empty()) return;
  const fs::path folder = path_ / kSampleFolder;
  std::error_code error;
  fs::create_directory(folder, error);
  write_file(folder / (id + ".png"), png);
}

std::map<std::string, Bytes> ResultFolder::samples() const {
  std::map<std::string, Bytes> samples;
  for (const RegistryEntry& entry : registry()) {
    const std::string id(entry.id);
    const std::optional<std::string> text = content(path_ / kSampleFolder / (id + ".png"));
    if (!text) continue;
    const auto bytes = std::as_bytes(std::span(text->data(), text->size()));
    samples[id].assign(bytes.begin(), bytes.end());
  }
  return samples;
}

void ResultFolder::write_report(const std::string& html) const {
  write_file(path_ / kReportFile, html);
}

}  // namespace engram
