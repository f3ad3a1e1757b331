#include "protocol/datasets/collection_report.h"

#include <algorithm>

#include "media/png.h"
#include "protocol/datasets/npz.h"
#include "protocol/io/decimal.h"
#include "protocol/io/html.h"

namespace engram {
namespace {

constexpr std::size_t kImages = 6;  // of an episode

double mebibytes(const DemonstrationFolder& folder) {
  double bytes = 0;
  for (int i = 0; i < folder.episodes(); ++i) {
    bytes += static_cast<double>(std::filesystem::file_size(folder.file(i)));
  }
  return bytes / (1 << 20);
}

// Moments of an episode from left to right, base camera above wrist camera.
std::vector<std::byte> strip(const NpzFile& file) {
  const std::vector<std::int64_t> shape = file.shape("rgb", NpyType::kUint8);
  const std::vector<std::byte> rgb = file.read("rgb", NpyType::kUint8, shape);
  const auto steps = static_cast<std::size_t>(shape[0]);
  const auto height = static_cast<std::size_t>(shape[1]);
  const auto width = static_cast<std::size_t>(shape[2]);
  const std::size_t count = std::min(kImages, steps);
  std::vector<std::uint8_t> pixels(2 * height * count * width * 3);
  auto out = pixels.begin();
  for (std::size_t camera = 0; camera < 2; ++camera) {
    for (std::size_t y = 0; y < height; ++y) {
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t step = count == 1 ? 0 : i * (steps - 1) / (count - 1);
        const std::byte* pixel = rgb.data() + ((step * height + y) * width * 2 + camera) * 3;
        for (std::size_t x = 0; x < width; ++x, pixel += 6) {
          for (std::size_t c = 0; c < 3; ++c) *out++ = std::to_integer<std::uint8_t>(pixel[c]);
        }
      }
    }
  }
  return png_bytes(static_cast<int>(count * width), static_cast<int>(2 * height), pixels);
}

}  // namespace

double keep_rate(const DemonstrationFolder& folder) {
  const int attempts = folder.attempts();
  return attempts == 0 ? 0.0 : static_cast<double>(folder.attempts_kept()) / attempts;
}

std::string collection_report(std::span<const std::unique_ptr<DemonstrationFolder>> folders,
                              const CollectionTiming& timing) {
  HtmlReport report("Demonstrations of " + counted(folders.size(), "task"));
  const double seconds = std::max(timing.seconds, 1e-9);
  report.paragraph(
      "This run added " + counted(static_cast<std::size_t>(timing.episodes), "episode") + " in " +
      decimal(timing.seconds, 1) + " s: " + decimal(60 * timing.episodes / seconds, 0) +
      " episodes per minute, " + decimal(static_cast<double>(timing.env_steps) / seconds, 0) +
      " environment steps per second, with images.");
  std::vector<HtmlReport::RateBar> bars;
  std::vector<std::vector<std::string>> rows;
  for (const auto& folder : folders) {
    const RegistryEntry& entry = folder->entry();
    const double episodes = std::max(1, folder->episodes());
    bars.push_back({.label = std::string(entry.id),
                    .value = keep_rate(*folder),
                    .group = std::string(split_name(entry.split))});
    rows.push_back({std::string(entry.id), std::to_string(folder->episodes()),
                    std::to_string(folder->attempts()),
                    std::to_string(collection_rule(entry).batch), decimal(keep_rate(*folder), 3),
                    std::to_string(folder->steps()),
                    decimal(static_cast<double>(folder->steps()) / episodes, 1),
                    decimal(mebibytes(*folder), 1)});
  }
  report.heading("Attempts kept");
  report.bars(bars);
  report.table({"task", "episodes", "attempts", "episodes per attempt", "kept", "steps",
                "mean steps", "MiB"},
               rows);
  report.heading("First episodes");
  for (const auto& folder : folders) {
    if (folder->episodes() == 0) continue;
    report.image(std::string(folder->entry().id) + ": " + std::string(folder->entry().instruction),
                 strip(NpzFile(folder->file(0))));
  }
  return report.text();
}

}  // namespace engram
