// Images of MJCF documents, with their bodies where they are in one environment.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/image/image_changes.h"
#include "core/image/renderer.h"
#include "core/math/frame.h"

namespace engram {

// Pose and appearance of a body.
struct BodyView {
  Frame frame;  // world
  bool visible = true;
  // Colour that replaces the document's if its alpha is positive, 0..1, as displays want it; and
  // added emission.
  float rgba[4] = {0, 0, 0, 0};
  float emission = 0;
};

class ImageSource {
 public:
  // `bodies` names what BodyViews stand for. With shadows, the slanted light casts soft ones.
  // Throws Error for a refused document, or if the renderer does not exist or cannot work here.
  ImageSource(const std::string& document, const std::vector<std::string>& bodies,
              const ImageSourceOptions& options, int workers, const RendererFactory& make_renderer);
  ~ImageSource();

  // Names, in the order in which RenderImage::camera counts them.
  const std::vector<std::string>& cameras() const { return cameras_; }
  // Names of the values of segmentation images: index -> name. 0 is the background.
  const std::vector<std::string>& segments() const { return segments_; }
  // `bodies` in the order that the source was made for. changes: of a source whose options say that
  // it varies; null: none. Noise and blur are left to the caller. Does not allocate, lock or throw.
  void render(int worker, std::span<const BodyView> bodies, std::span<const RenderImage> images,
              const ImageChanges* changes = nullptr);

 private:
  struct Scene;
  struct Workspace;

  std::vector<std::string> cameras_;
  std::vector<std::string> segments_;
  std::unique_ptr<const Scene> scene_;
  std::vector<Workspace> workspaces_;  // one per worker
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace engram
