#include "apps/record_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "api/media.h"
#include "apps/options.h"
#include "apps/output.h"
#include "apps/progress.h"
#include "apps/record_episode.h"
#include "apps/record_sheet.h"
#include "apps/record_view.h"
#include "apps/run_flags.h"
#include "apps/task_choice.h"
#include "protocol/eval/results/result_files.h"
#include "protocol/eval/run/choice_tasks.h"

namespace engram::apps {
namespace {

constexpr int kSize = 512;
constexpr int kSheetSize = 320;  // of an image in a sheet, as in the published previews
constexpr int kMaxSize = 4096;   // of Batch::render
constexpr int kMaxSheet = 60;
constexpr int kStepsPerSecond = 20;  // of control
constexpr int kMaxHold = 60;         // seconds

struct RecordOptions {
  std::string out;
  EpisodeOptions episode;
  ViewOptions view;
  int size = 0;  // 0: not given, as below
  int frames_per_second = 0;
  std::optional<std::array<int, 2>> hold;  // seconds of a video's first and last frame
  int sheet = 0;                           // images of a sheet that is spread over the episode
  std::vector<int> at;                     // steps to take images of
  std::optional<bool> shadows;             // by default, those that stand still have them
  bool json = false;

  bool is_sheet() const { return sheet > 0 || at.size() > 1; }
};

[[noreturn]] void refuse(const std::string& what) { throw Error(Error::kInvalidArgument, what); }

std::string extension_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

struct RecordReport {
  int frames = 0;
  int width = 0;
  int height = 0;
  bool success_once = false;
  int chunk_size = 1;
};

// --- videos ---

// Multiples of the steps' rate repeat images, so that the video stays in real time.
int frames_per_step(int frames_per_second) {
  return frames_per_second % kStepsPerSecond == 0 ? frames_per_second / kStepsPerSecond : 1;
}

RecordReport record_video(const RecordOptions& options, RecordedEpisode& episode) {
  RecordView view(episode.batch(), options.view);
  VideoWriter video(options.out, view.width(), view.height(), options.frames_per_second);
  Progress progress("record", "frames");
  RecordReport report{.width = view.width(), .height = view.height()};
  const auto [first, last] = *options.hold;
  const int repeat = frames_per_step(options.frames_per_second);
  const auto add = [&](int seconds) {
    const std::vector<std::uint8_t> frame = view.draw();
    const int count = std::max(repeat, seconds * options.frames_per_second);
    for (int i = 0; i < count; ++i) video.add(frame);
    report.frames += count;
    progress.update((episode.steps() + 1.0) / (episode.max_steps() + 1.0), report.frames);
  };
  add(first);
  while (!episode.over()) {
    episode.step();
    add(episode.over() ? last : 0);
  }
  video.finish();
  return report;
}

// --- images ---

// The steps to show: those that were asked for, or some from the first to the last.
std::vector<int> moments_of(const RecordOptions& options, RecordedEpisode& episode) {
  if (options.sheet == 0) return options.at;
  const std::vector<int> changes = phase_changes(episode.batch());
  while (!episode.over()) episode.step();
  const int steps = episode.steps();
  episode.rewind();
  return sheet_steps(options.sheet, steps, changes);
}

// Steps until `step`; false if the episode ends before.
bool step_until(int step, RecordedEpisode& episode) {
  while (episode.steps() < step && !episode.over()) episode.step();
  return episode.steps() == step;
}

void go_to(int step, RecordedEpisode& episode) {
  if (step_until(step, episode)) return;
  refuse(fmt::format("--at: {} given, 0 to {} allowed; the episode ends with step {}", step,
                     episode.steps(), episode.steps()));
}

RecordReport record_image(const RecordOptions& options, RecordedEpisode& episode) {
  RecordView view(episode.batch(), options.view);
  go_to(options.at[0], episode);
  write_png(options.out, view.width(), view.height(), view.draw());
  return {.frames = 1, .width = view.width(), .height = view.height()};
}

RecordReport record_sheet(const RecordOptions& options, RecordedEpisode& episode) {
  const std::vector<int> moments = moments_of(options, episode);
  RecordView view(episode.batch(), options.view);
  const auto count = static_cast<int>(moments.size());
  RecordSheet sheet(count, view.width(), view.height());
  RecordReport report{.width = sheet.width(), .height = sheet.height()};
  Progress progress("record", "pictures");
  for (const int moment : moments) {
    go_to(moment, episode);
    sheet.add(moment, view.draw());
    ++report.frames;
    progress.update(static_cast<double>(report.frames) / count, report.frames);
  }
  step_until(episode.max_steps(), episode);
  write_png(options.out, report.width, report.height, sheet.rgb());
  return report;
}

// --- options ---

void complete_size(RecordOptions& options) {
  ViewOptions& view = options.view;
  const int standard = options.is_sheet() ? kSheetSize : kSize;
  if (view.camera != "all") {
    if (view.sensor_size > 0) refuse("--sensor-size: only --camera all has sensors beside it");
    if (view.width == 0) view.width = options.size > 0 ? options.size : standard;
    if (view.height == 0) view.height = options.size > 0 ? options.size : standard;
    return;
  }
  if (view.width > 0 || view.height > 0) {
    refuse("--width, --height: of single cameras only; --camera all takes --size, its height");
  }
  view.height = options.size > 0 ? options.size : standard;
  if (view.height % 4 != 0) {
    refuse(fmt::format("--size: {} given, multiples of 4 allowed with --camera all", view.height));
  }
  view.width = view.height / 2 * 3;
}

// The policy and what it sees, as in results of an evaluation.
EvaluationSettings settings_of(const EpisodeOptions& episode) {
  EvaluationSettings settings;
  settings.tasks = {episode.id};
  static_cast<RunOptions&>(settings) = episode.run;
  name_policy(episode.command, episode.policy, settings);
  settings.set_environment(episode.command.given() ? episode.observed() : episode.env);
  return settings;
}

// Fills in the options that were not given.
RecordOptions completed(RecordOptions options) {
  const std::string extension = extension_of(options.out);
  const bool image = extension == ".png";
  if (!image && extension != ".gif" && extension != ".mp4") {
    refuse(fmt::format("--out: '{}' given, a name that ends in .png, .gif or .mp4 allowed",
                       options.out));
  }
  if (!image && (options.sheet > 0 || !options.at.empty())) {
    refuse(fmt::format("--at, --sheet: images of single steps; --out: '{}' given, .png allowed",
                       options.out));
  }
  if (image && options.frames_per_second > 0) refuse("--fps: videos only; a .png stands still");
  if (image && options.hold) refuse("--hold: videos only; a .png stands still");
  if (options.view.overlays && (options.view.camera == "base" || options.view.camera == "hand")) {
    refuse(fmt::format("--overlays: human views only; --camera: '{}' given, render|all allowed",
                       options.view.camera));
  }
  if (options.frames_per_second == 0) options.frames_per_second = kStepsPerSecond;
  if (!options.hold) options.hold = {1, 2};
  if (options.at.empty()) options.at = {0};
  std::sort(options.at.begin(), options.at.end());
  complete_size(options);
  EpisodeOptions& episode = options.episode;
  if (episode.obs && !episode.command.given()) {
    refuse(
        "--obs: what --policy-command, --policy-choices or --policy-server sees; no such policy "
        "given");
  }
  if (episode.command.choices) require_choices(settings_of(episode));
  MakeOptions& env = episode.env;
  env.policy_seed = episode.run.policy_seed;
  env.obs_mode = ObsMode::kNone;
  env.auto_reset = AutoReset::kOff;  // the last frame is that of the last step
  env.image_options.renderer = env.render_options.renderer;
  env.render_options.shadows = options.shadows.value_or(image);
  // Sensors at their own size are what policies see; larger ones are for people.
  env.image_options.antialias = options.view.sensor_size == 0;
  return options;
}

// --- the command ---

RecordReport record(const RecordOptions& options) {
  const bool image = extension_of(options.out) == ".png";
  const Interruption interruption;
  try {
    RecordedEpisode episode(options.episode, interruption);
    warn_of_constants(options.episode.id, options.episode.env);
    const auto write = !image ? record_video : options.is_sheet() ? record_sheet : record_image;
    RecordReport report = write(options, episode);
    report.success_once = episode.success_once();
    report.chunk_size = episode.chunk_size();
    return report;
  } catch (const Error&) {
    // A policy that was no longer waited for has not failed.
    interruption.check("nothing was written");
    throw;
  }
}

// The policy is described as in results of an evaluation.
Json to_document(const RecordOptions& options, const RecordReport& report) {
  const EpisodeOptions& episode = options.episode;
  const EvaluationSettings settings = settings_of(episode);
  JsonTable document{{"out", options.out},
                     {"frames", report.frames},
                     {"success_once", report.success_once},
                     {"obs_mode", name_of(settings.obs_mode)},
                     {"action_chunk_size", report.chunk_size},
                     {"model", model_document(settings)}};
  if (settings.choices) document.emplace_back("choices", true);
  return document;
}

void run(const RecordOptions& given) {
  const RecordOptions options = completed(given);
  const RecordReport report = record(options);
  if (options.json) {
    print(to_text(to_document(options, report)));
    return;
  }
  std::string length = report.frames == 1 ? "1 frame" : fmt::format("{} frames", report.frames);
  if (extension_of(options.out) != ".png") {
    length += fmt::format(" ({:.2f} s)", 1.0 * report.frames / options.frames_per_second);
  }
  print(fmt::format("{}: {} of {}, {} x {} pixels, {}\n", options.out, length, options.episode.id,
                    report.width, report.height, report.success_once ? "success" : "no success"));
}

void add_camera(const Command& command, std::string& camera) {
  const auto assign = [&camera](const std::string& text) {
    if (text != "base" && text != "hand" && text != "render" && text != "all") {
      refuse(fmt::format("--camera: '{}' given, base|hand|render|all allowed", text));
    }
    camera = text;
  };
  command
      .add_option("--camera", assign, "One view, or all: the human view beside both sensors, 3 : 2")
      .type_name("base|hand|render|all")
      .default_str(camera);
}

void add_moments(const Command& command, RecordOptions& options) {
  const auto assign = [&options](const std::string& text) {
    for (std::size_t begin = 0; begin <= text.size();) {
      const std::size_t comma = std::min(text.find(',', begin), text.size());
      options.at.push_back(parse_int("--at", text.substr(begin, comma - begin), 0, 1'000'000));
      begin = comma + 1;
    }
    if (options.at.size() > kMaxSheet) {
      refuse(fmt::format("--at: {} steps given, at most {} allowed", options.at.size(), kMaxSheet));
    }
  };
  const Option at = command.add_option(
      "--at", assign, ".png: after that many steps; of several, a sheet of images");
  at.type_name("STEP,...").default_str("0");
  add_int(command, "--sheet", options.sheet, 1, kMaxSheet,
          ".png: a sheet of N images: the first and the last step, changes of phase, others")
      .default_str("")
      .excludes(at);
}

void add_time(const Command& command, RecordOptions& options) {
  add_int(
      command, "--fps", options.frames_per_second, 1, 240,
      "Videos: frames per second, one for each step; 20 is real time, and so are its multiples, "
      "which repeat frames (.gif: at most 50)")
      .default_str(std::to_string(kStepsPerSecond));
  const auto assign = [&options](const std::string& text) {
    const std::size_t comma = text.find(',');
    if (comma == std::string::npos) {
      refuse(fmt::format("--hold: '{}' given, FIRST,LAST needed, such as 0,0", text));
    }
    options.hold = {parse_int("--hold", text.substr(0, comma), 0, kMaxHold),
                    parse_int("--hold", text.substr(comma + 1), 0, kMaxHold)};
  };
  command
      .add_option("--hold", assign,
                  "Videos: seconds for which the first and the last frame stay; 0: one step")
      .type_name("FIRST,LAST")
      .default_str("1,2");
}

void add_view(const Command& command, RecordOptions& options) {
  add_camera(command, options.view.camera);
  command.add_flag("--overlays", options.view.overlays,
                   "Step, reward and the quantity to remember, over the human view");
  const Option size = add_int(command, "--size", options.size, 1, kMaxSize,
                              "Height in pixels, and width of one camera")
                          .default_str(fmt::format("{}, {} in sheets", kSize, kSheetSize));
  for (const auto& [name, value] :
       {std::pair{"--width", &options.view.width}, {"--height", &options.view.height}}) {
    add_int(command, name, *value, 1, kMaxSize, "Pixels of one camera")
        .default_str("")
        .excludes(size);
  }
  add_int(command, "--sensor-size", options.view.sensor_size, 1, kMaxSize,
          "--camera all: pixels of the sensors, enlarged; 128 is the size for policies")
      .default_str("");
  add_renderer(command, options.episode.env.render_options);
  const Option on = command.add_flag(
      "--shadows", [&options] { options.shadows = true; },
      "Soft shadows in the human view; slower. Default: in images and sheets");
  command
      .add_flag(
          "--no-shadows", [&options] { options.shadows = false; }, "No shadows")
      .excludes(on);
}

}  // namespace

void add_record_command(const Command& program) {
  const auto options = std::make_shared<RecordOptions>();
  const Command command = program.add_command("record", "Image or video of an episode");
  EpisodeOptions& episode = options->episode;
  episode.env = batch_options(1, 1);
  command.add_option("id", episode.id, "The task, such as RememberColor9-VLA-v0")
      .required()
      .type_name("ID");
  command.add_option("--out", options->out, "File to write: .png, .gif or .mp4")
      .required()
      .type_name("FILE");
  add_view(command, *options);
  add_moments(command, *options);
  add_time(command, *options);
  add_int(command, "--steps", episode.steps, 1, 1'000'000, "Control steps, at most")
      .type_name("T")
      .default_str("to the end of the episode");
  add_seed(command, episode.env.seed, "Of the episode");
  add_policy_command(command, add_policy(command, episode.policy, kTaskPolicies), episode.command);
  add_obs_mode(command, episode.obs, kObsModes)
      .description("Observation of --policy-command, --policy-choices and --policy-server")
      .default_str(std::string(name_of(ObsMode::kRgb)));
  add_run_flags(command, "record", episode.run);
  add_env_options(command, episode.env);
  command.remove_option("--auto-reset");  // there is one episode
  add_json(command, options->json);
  command.footer(
      "Videos have a frame of the beginning and one after every step; the first and the last stay "
      "for a while. success_once is that of the steps taken: a single image ends with its own, "
      "sheets and videos with the episode.");
  command.on_run([options] { run(*options); });
}

}  // namespace engram::apps
