#include "apps/record_sheet.h"

#include <algorithm>
#include <set>
#include <string>

#include "core/batch/queries.h"

namespace engram::apps {
namespace {

constexpr int kColumns = 3;
constexpr int kMinLabel = 8;         // pixels
constexpr double kLabelShare = 0.1;  // of an image's shorter side
constexpr double kLabelRoom = 32;    // height of a label in pixels at the text's scale 1

int columns_of(int images) { return std::min(images, kColumns); }

int rows_of(int images) { return (images + columns_of(images) - 1) / columns_of(images); }

int label_of(int width, int height) {
  return std::max(kMinLabel, static_cast<int>(kLabelShare * std::min(width, height)));
}

int gutter_of(int width, int height) { return label_of(width, height) / 4; }

// The middle of the longest way between two neighbours; 0 if all adjoin.
int middle_of_widest(const std::set<int>& steps) {
  int widest = 1;
  int middle = 0;
  for (auto next = std::next(steps.begin()); next != steps.end(); ++next) {
    const int before = *std::prev(next);
    if (*next - before <= widest) continue;
    widest = *next - before;
    middle = before + widest / 2;
  }
  return middle;
}

}  // namespace

std::vector<int> phase_changes(const Batch& batch) {
  const Queries queries(batch);
  const std::vector<Field>& fields = batch.info().sampled_values;
  std::vector<float> values(static_cast<std::size_t>(queries.sampled_dim() * batch.num_envs()));
  queries.sampled_values(values);
  std::vector<int> changes;
  std::size_t place = 0;
  int step = 0;
  for (const Field& field : fields) {
    if (field.name == "cue_steps_per_env" || field.name == "empty_steps_per_env") {
      step += static_cast<int>(values[place]);
      changes.push_back(step);
    }
    place += static_cast<std::size_t>(field.width);
  }
  return changes;
}

std::vector<int> sheet_steps(int count, int last, std::span<const int> changes) {
  std::set<int> steps = {last};
  const auto is_full = [&] { return std::ssize(steps) >= std::min(count, last + 1); };
  if (!is_full()) steps.insert(0);
  for (const int change : changes) {
    if (!is_full() && change < last) steps.insert(change);
  }
  while (!is_full()) steps.insert(middle_of_widest(steps));
  return {steps.begin(), steps.end()};
}

RecordSheet::RecordSheet(int images, int width, int height)
    : columns_(columns_of(images)),
      image_width_(width),
      image_height_(height),
      gutter_(gutter_of(width, height)),
      label_(label_of(width, height)),
      canvas_(columns_ * (width + gutter_) - gutter_,
              rows_of(images) * (label_ + height + gutter_) - gutter_) {}

void RecordSheet::add(int step, std::span<const std::uint8_t> rgb) {
  const int x = added_ % columns_ * (image_width_ + gutter_);
  const int y = added_ / columns_ * (label_ + image_height_ + gutter_);
  canvas_.text({static_cast<double>(x + gutter_), y + 0.8 * label_}, "step " + std::to_string(step),
               label_ / kLabelRoom);
  canvas_.blit(x, y + label_, image_width_, image_height_, rgb);
  ++added_;
}

}  // namespace engram::apps
