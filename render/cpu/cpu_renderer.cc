#include "render/cpu/cpu_renderer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/base/error.h"
#include "render/cpu/backdrop.h"
#include "render/cpu/frame_builder.h"
#include "render/cpu/frame_data.h"
#include "render/cpu/prepared_scene.h"

namespace engram {
namespace {

using cpu::Backdrop;
using cpu::Band;
using cpu::FrameData;
using cpu::kBlock;
using cpu::Kernel;
using cpu::kPanelTiles;
using cpu::padded;
using cpu::TileRow;

constexpr int kBandPixels = 8192;  // three words each: a band stays in the caches
constexpr int kLargestSide = 16384;

// Null if the library or the machine lacks it.
const Kernel* find_kernel(InstructionSet set) {
  if (!is_available(set)) return nullptr;
  switch (set) {
    case InstructionSet::kBaseline:
      return cpu::baseline_kernel();
    case InstructionSet::kAvx2:
      return cpu::avx2_kernel();
    case InstructionSet::kAvx512:
      return cpu::avx512_kernel();
    case InstructionSet::kAuto:
      for (const auto best : {InstructionSet::kAvx512, InstructionSet::kAvx2}) {
        if (const Kernel* kernel = find_kernel(best)) return kernel;
      }
      return cpu::baseline_kernel();
  }
  return nullptr;
}

void check(const CpuRendererOptions& options, int workers) {
  const auto check_range = [](const char* name, double value, double low, double high) {
    if (value >= low && value <= high) return;
    throw Error(Error::kInvalidArgument, std::string("cpu renderer: ") + name + " is " +
                                             std::to_string(value) + "; allowed are " +
                                             std::to_string(low) + " to " + std::to_string(high));
  };
  check_range("workers", workers, 1, 4096);
  check_range("shadow_rays", options.shadow_rays, 0, cpu::kMaxRays);
  check_range("shadow_softness", static_cast<double>(options.shadow_softness), 0, 0.5);
  check_range("max_width", options.max_width, 1, kLargestSide);
  check_range("max_height", options.max_height, 1, kLargestSide);
  if (find_kernel(options.instruction_set) == nullptr) {
    throw Error(Error::kUnavailable, std::string("cpu renderer: this machine or build lacks ") +
                                         name_of(options.instruction_set));
  }
}

void store_colors(const std::uint32_t* colors, int count, std::ptrdiff_t stride,
                  std::uint8_t* out) {
  for (int x = 0; x < count; ++x, out += stride) cpu::store_color(colors[x], out);
}

// Means of 2x2 samples.
void store_means(const std::uint32_t* upper, const std::uint32_t* lower, int count,
                 std::ptrdiff_t stride, std::uint8_t* out) {
  constexpr std::uint32_t kRedBlue = 0x00ff00ff;
  constexpr std::uint32_t kGreen = 0x0000ff00;
  for (int x = 0; x < count; ++x) {
    const std::uint32_t s[4] = {upper[2 * x], upper[2 * x + 1], lower[2 * x], lower[2 * x + 1]};
    const std::uint32_t red_blue =
        (s[0] & kRedBlue) + (s[1] & kRedBlue) + (s[2] & kRedBlue) + (s[3] & kRedBlue) + 0x00020002;
    const std::uint32_t green =
        (s[0] & kGreen) + (s[1] & kGreen) + (s[2] & kGreen) + (s[3] & kGreen) + 0x00000200;
    out[0] = static_cast<std::uint8_t>(red_blue >> 2);
    out[1] = static_cast<std::uint8_t>(green >> 10);
    out[2] = static_cast<std::uint8_t>(red_blue >> 18);
    out += stride;
  }
}

bool has_integer_outputs(const RenderImage& image) {
  return image.depth_mm != nullptr || image.segment_id != nullptr;
}

// Side by side, or neither.
bool are_neighbours(const std::int16_t* first, const std::int16_t* second) {
  return first == nullptr || second == nullptr ? first == second : second == first + 1;
}

// Two images of one size that share their pixels: three bytes of each, or two.
bool are_interleaved(const RenderImage& first, const RenderImage& second) {
  if (first.width != second.width || first.height != second.height) return false;
  if (has_integer_outputs(first) &&
      !(first.cell_step == 2 && second.cell_step == 2 && first.cell_row == second.cell_row)) {
    return false;
  }
  return are_neighbours(first.depth_mm, second.depth_mm) &&
         are_neighbours(first.segment_id, second.segment_id) && first.pixel_stride == 6 &&
         second.pixel_stride == 6 && first.row_stride == second.row_stride &&
         first.rgb != nullptr && second.rgb == first.rgb + 3;
}

// The kernels' arithmetic: from w = 1 / depth.
std::int16_t millimetres(float w) {
  constexpr float kMax = 32767;
  return static_cast<std::int16_t>(std::lrint(std::min(1000 / w, kMax)));
}

class CpuRenderer final : public Renderer {
 public:
  CpuRenderer(const RenderScene& scene, const CpuRendererOptions& options, int workers)
      : prepared_(scene, options),
        options_(options),
        kernel_(find_kernel(options.instruction_set)),
        backdrops_(prepared_, draws_tiles() ? max_pixels(samples()) : 0),
        segmented_(prepared_, draws_tiles() ? max_pixels(1) : 0, true) {
    for (int i = 0; i < workers; ++i) workspaces_.push_back(std::make_unique<Workspace>(*this));
  }

  const char* name() const override { return "cpu"; }

  void render(int worker, const RenderInstances& instances,
              std::span<const RenderImage> images) override {
    Workspace& workspace = *workspaces_[static_cast<std::size_t>(worker)];
    for (std::size_t i = 0; i < images.size(); ++i) {
      const RenderImage& image = images[i];
      if (!fits(image)) continue;
      if (!is_plain(image)) {
        render(workspace, instances, image);
        continue;
      }
      const RenderImage* other = i + 1 < images.size() ? &images[i + 1] : nullptr;
      if (other != nullptr && fits(*other) && is_plain(*other) && draws_pairs() &&
          are_interleaved(image, *other)) {
        draw_both(workspace, instances, image, *other);
        ++i;
      } else {
        draw_tiles(workspace, instances, image);
      }
    }
  }

 private:
  // Working memory of one thread.
  struct Workspace {
    explicit Workspace(const CpuRenderer& owner)
        : builder(owner.make_builder()),
          w(owner.band_size()),
          id(w.size()),
          color(w.size()),
          tile_w(2 * owner.tiles_size()),
          tile_codes(tile_w.size()),
          candidates(owner.prepared_.scene.geoms.size()) {
      for (std::size_t i = 0; i < 2; ++i) {
        rows[i].pitch = static_cast<int>(owner.tiles_size()) / kBlock;
        rows[i].code = tile_codes.data() + i * owner.tiles_size();
        rows[i].candidates = candidates.data();
      }
      keep_depths(false);
      if (owner.draws_pairs()) other_builder.emplace(owner.make_builder());
    }

    // Cameras of a pair share the memory for depths unless those are wanted.
    void keep_depths(bool wanted) {
      for (std::size_t i = 0; i < 2; ++i) {
        rows[i].keeps_depth = wanted;
        rows[i].w = tile_w.data() + (wanted ? i * tile_w.size() / 2 : 0);
      }
    }

    cpu::FrameBuilder builder;
    std::optional<cpu::FrameBuilder> other_builder;  // of the second camera of a pair
    AlignedArray<float> w;
    AlignedArray<std::int32_t> id;
    AlignedArray<std::uint32_t> color;
    TileRow rows[2] = {};
    AlignedArray<float> tile_w;
    AlignedArray<std::int32_t> tile_codes;
    std::vector<cpu::TileCandidate> candidates;
  };

  // One camera's view, to be drawn in tiles.
  struct TileSource {
    const FrameData* frame;
    const Backdrop* backdrop;
  };

  // The images of a camera that are drawn from one frame.
  struct Outputs {
    bool colors;
    bool depth;
    bool segments;
  };

  // Frames in colours, and with segments for colours.
  struct PreparedFrames {
    TileSource colors;
    TileSource segments;
  };

  cpu::FrameBuilder make_builder() const {
    return {prepared_, kernel_->setup, samples() * options_.max_width,
            samples() * options_.max_height};
  }

  int samples() const { return options_.antialias ? 2 : 1; }

  std::int64_t max_pixels(int scale) const {
    return std::int64_t{padded(scale * options_.max_width)} * scale * options_.max_height;
  }

  // Pixels of a row of tiles.
  std::size_t tiles_size() const {
    const int widest = std::min(padded(samples() * options_.max_width), kPanelTiles * kBlock);
    return static_cast<std::size_t>(kBlock * (widest + kBlock));
  }

  // At least two rows of the widest image, for the means of 2x2 samples.
  std::size_t band_size() const {
    const int two_rows = 2 * padded(samples() * options_.max_width);
    return static_cast<std::size_t>(std::max(kBandPixels, two_rows));
  }

  bool fits(const RenderImage& image) const {
    return image.camera >= 0 && image.camera < static_cast<int>(prepared_.scene.cameras.size()) &&
           image.width > 0 && image.width <= options_.max_width && image.height > 0 &&
           image.height <= options_.max_height;
  }

  // Tiles are for images without shadows that observations can have: most images.
  bool draws_tiles() const { return !prepared_.casts_shadows(); }
  // Two cameras whose pixels lie side by side, at once.
  bool draws_pairs() const { return draws_tiles() && !options_.antialias; }
  bool is_plain(const RenderImage& image) const {
    return draws_tiles() && image.depth == nullptr && image.segment == nullptr &&
           (image.rgb != nullptr || has_integer_outputs(image));
  }

  PreparedFrames prepare_frames(Workspace& workspace, cpu::FrameBuilder& builder,
                                const RenderInstances& instances, const RenderImage& image,
                                int scale, const Outputs& outputs) {
    const int width = scale * image.width;
    const int height = scale * image.height;
    const auto find = [&](cpu::Backdrops& backdrops, bool wanted) {
      return wanted ? backdrops.find(instances, image.camera, width, height, *kernel_, builder,
                                     workspace.rows[0])
                    : nullptr;
    };
    const Backdrop* colors = find(backdrops_, outputs.colors);
    const Backdrop* segments = find(segmented_, outputs.segments);
    const FrameData* frame = nullptr;
    if ((colors != nullptr) == outputs.colors && (segments != nullptr) == outputs.segments) {
      frame = &builder.build(instances, image.camera, width, height, cpu::Shown::kMoving);
      // The one drawn first wins where two are equally near: the backdrop must come first.
      const cpu::Rank& last = (outputs.colors ? colors : segments)->last;
      if (!builder.ranks().empty() && !(last < builder.ranks().front())) frame = nullptr;
    }
    if (frame == nullptr) {
      frame = &builder.build(instances, image.camera, width, height);
      colors = segments = nullptr;
    }
    return {{frame, colors}, {outputs.segments ? &builder.segmented() : nullptr, segments}};
  }

  // Draws rows of tiles, part by part, and calls store(k, count) for `count` samples in each of
  // their rows k that begins a row of pixels: every `step` of them.
  template <typename Store>
  void draw_rows(const TileSource* sources, TileRow* rows, int count, int step, Store store) const {
    const int width = sources->frame->width;
    const int height = sources->frame->height;
    for (int y = 0; y < height; y += kBlock) {
      for (int x = 0; x < width; x += kPanelTiles * kBlock) {
        for (int i = 0; i < count; ++i) {
          rows[i].x = x;
          rows[i].y = y;
          rows[i].tiles = std::min(kPanelTiles, padded(width - x) / kBlock);
          rows[i].rows = std::min(kBlock, height - y);
          kernel_->draw_tiles(*sources[i].frame, sources[i].backdrop, rows[i]);
        }
        for (int k = 0; k < rows->rows; k += step) {
          store(k, std::min(kPanelTiles * kBlock, width - x));
        }
      }
    }
  }

  void draw_both(Workspace& workspace, const RenderInstances& instances, const RenderImage& image,
                 const RenderImage& other) {
    const Outputs outputs = {true, image.depth_mm != nullptr, image.segment_id != nullptr};
    const PreparedFrames frames[2] = {
        prepare_frames(workspace, workspace.builder, instances, image, 1, outputs),
        prepare_frames(workspace, *workspace.other_builder, instances, other, 1, outputs)};
    TileRow* rows = workspace.rows;
    const auto cells = [&](std::int16_t* first, int k) {
      return first + (rows->y + k) * image.cell_row + 2 * rows->x;
    };
    const TileSource colors[2] = {frames[0].colors, frames[1].colors};
    const float far_w[2] = {colors[0].frame->far_w, colors[1].frame->far_w};
    workspace.keep_depths(outputs.depth);
    draw_rows(colors, rows, 2, 1, [&](int k, int count) {
      kernel_->store_both(rows[0], rows[1], k, count,
                          image.rgb + (rows->y + k) * image.row_stride + 6 * rows->x);
      if (!outputs.depth) return;
      kernel_->store_both_depths(rows[0], rows[1], far_w, k, count, cells(image.depth_mm, k));
    });
    workspace.keep_depths(false);
    if (!outputs.segments) return;
    const TileSource segments[2] = {frames[0].segments, frames[1].segments};
    draw_rows(segments, rows, 2, 1, [&](int k, int count) {
      kernel_->store_both_segments(rows[0], rows[1], k, count, cells(image.segment_id, k));
    });
  }

  void draw_tiles(Workspace& workspace, const RenderInstances& instances,
                  const RenderImage& image) {
    const Outputs all = {image.rgb != nullptr, image.depth_mm != nullptr,
                         image.segment_id != nullptr};
    if (!options_.antialias || !all.colors || !has_integer_outputs(image)) {
      draw_tiles(workspace, instances, image, all.colors ? samples() : 1, all);
      return;
    }
    draw_tiles(workspace, instances, image, samples(), {true, false, false});
    draw_tiles(workspace, instances, image, 1, {false, all.depth, all.segments});
  }

  // With colours or segments. Depth comes with either.
  void draw_tiles(Workspace& workspace, const RenderInstances& instances, const RenderImage& image,
                  int scale, Outputs outputs) {
    const bool stores_segments = outputs.segments;
    outputs.segments |= !outputs.colors;
    const PreparedFrames frames =
        prepare_frames(workspace, workspace.builder, instances, image, scale, outputs);
    TileRow& row = workspace.rows[0];
    const auto cells = [&](std::int16_t* first, int k) {
      return first + (row.y + k) * image.cell_row + row.x * image.cell_step;
    };
    const auto store_depths = [&](int k, int count) {
      kernel_->store_depths(row, frames.colors.frame->far_w, k, count, image.cell_step,
                            cells(image.depth_mm, k));
    };
    workspace.keep_depths(outputs.depth);
    if (outputs.colors) {
      draw_rows(&frames.colors, &row, 1, scale, [&](int k, int count) {
        store_tiles(row, k, count, image);
        if (outputs.depth) store_depths(k, count);
      });
    }
    workspace.keep_depths(outputs.depth && !outputs.colors);
    if (outputs.segments) {
      draw_rows(&frames.segments, &row, 1, 1, [&](int k, int count) {
        if (stores_segments) {
          kernel_->store_segments(row, k, count, image.cell_step, cells(image.segment_id, k));
        }
        if (row.keeps_depth) store_depths(k, count);
      });
    }
    workspace.keep_depths(false);
  }

  void store_tiles(const TileRow& row, int k, int count, const RenderImage& image) const {
    std::uint8_t* out = image.rgb + (row.y + k) / samples() * image.row_stride +
                        row.x / samples() * image.pixel_stride;
    for (int x = 0; x < count; x += kBlock) {
      const int tile = x / kBlock;
      const std::uint32_t* colors = row.source[tile] + k * row.stride[tile];
      store(colors, colors + row.stride[tile], std::min(kBlock, count - x) / samples(), image,
            out + x / samples() * image.pixel_stride);
    }
  }

  void render(Workspace& workspace, const RenderInstances& instances, const RenderImage& image) {
    const bool wants_other =
        image.depth != nullptr || image.segment != nullptr || has_integer_outputs(image);
    if (options_.antialias) {
      if (image.rgb != nullptr) draw(workspace, instances, image, 2, true, false);
      if (wants_other) draw(workspace, instances, image, 1, false, true);
    } else {
      draw(workspace, instances, image, 1, image.rgb != nullptr, wants_other);
    }
  }

  void draw(Workspace& workspace, const RenderInstances& instances, const RenderImage& image,
            int scale, bool colors, bool other) {
    const int width = scale * image.width;
    const int height = scale * image.height;
    const FrameData& frame = workspace.builder.build(instances, image.camera, width, height);
    Band band = {
        0, 0, padded(width), workspace.w.data(), workspace.id.data(), workspace.color.data()};
    const int rows = static_cast<int>(workspace.w.size()) / band.width / scale * scale;
    for (band.y0 = 0; band.y0 < height; band.y0 = band.y1) {
      band.y1 = std::min(band.y0 + rows, height);
      kernel_->trace(frame, band);
      if (colors) {
        kernel_->shade(frame, band);
        store(band, image, scale);
      }
      if (other) store_other(frame, band, image);
    }
  }

  // A row of samples, or two of them.
  void store(const std::uint32_t* upper, const std::uint32_t* lower, int pixels,
             const RenderImage& image, std::uint8_t* out) const {
    if (options_.antialias) {
      store_means(upper, lower, pixels, image.pixel_stride, out);
    } else if (image.pixel_stride == 6) {
      kernel_->store_pairs(upper, pixels, out);
    } else {
      store_colors(upper, pixels, image.pixel_stride, out);
    }
  }

  void store(const Band& band, const RenderImage& image, int scale) const {
    for (int y = band.y0; y < band.y1; y += scale) {
      const std::uint32_t* row = band.color + static_cast<std::ptrdiff_t>(y - band.y0) * band.width;
      store(row, row + band.width, image.width, image, image.rgb + (y / scale) * image.row_stride);
    }
  }

  // Depth and segmentation.
  static void store_other(const FrameData& frame, const Band& band, const RenderImage& image) {
    for (int y = band.y0; y < band.y1; ++y) {
      const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(y - band.y0) * band.width;
      const std::ptrdiff_t out = static_cast<std::ptrdiff_t>(y) * image.width;
      for (int x = 0; x < image.width; ++x) {
        const std::int32_t id = band.id[row + x];
        if (image.depth != nullptr) image.depth[out + x] = id == 0 ? 0 : 1 / band.w[row + x];
        const auto segment = static_cast<std::int32_t>(frame.segments[id]);
        if (image.segment != nullptr) image.segment[out + x] = segment;
        const std::ptrdiff_t cell = y * image.cell_row + x * image.cell_step;
        if (image.depth_mm != nullptr) {
          image.depth_mm[cell] = id == 0 ? std::int16_t{0} : millimetres(band.w[row + x]);
        }
        if (image.segment_id != nullptr) {
          image.segment_id[cell] = static_cast<std::int16_t>(segment);
        }
      }
    }
  }

  cpu::PreparedScene prepared_;
  CpuRendererOptions options_;
  const Kernel* kernel_;
  cpu::Backdrops backdrops_;
  cpu::Backdrops segmented_;
  std::vector<std::unique_ptr<Workspace>> workspaces_;
};

}  // namespace

bool is_supported(InstructionSet set) { return find_kernel(set) != nullptr; }

std::unique_ptr<Renderer> make_cpu_renderer(const RenderScene& scene,
                                            const CpuRendererOptions& options, int workers) {
  check(options, workers);
  return std::make_unique<CpuRenderer>(scene, options, workers);
}

}  // namespace engram
