#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "renderd/composite/assistant.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// Passes tasks and parts between an assistant's connection and its renderer. Thread-safe.
class AssistDesk {
 public:
  /// The newest task. Versions count from 1; before the first task they are 0 and null.
  struct Order {
    std::uint64_t version = 0;
    std::shared_ptr<const AssistTask> task;
  };

  void put(AssistTask task);
  Order newest() const;
  /// Returns the task with this scene, compared by address. Works for as long as the runner may
  /// still use the scene.
  std::shared_ptr<const AssistTask> of(const diaphane::v1::Scene& scene) const;

  /// Records that the compositor took the part, and the progress of its picture.
  void taken(const AssistNews& news);
  AssistNews news() const;
  /// Returns whether no part is in transit.
  bool room() const;
  /// Returns whether further rendering is useful. It is not while as many samples as were delivered
  /// wait behind a part in transit (may_render).
  bool wants_more() const;

  // Called by the renderer.
  void began(const AssistTask& task);
  void drew(std::uint64_t held);
  void hand_over(AssistPart part);
  /// Returns the part from hand_over() once.
  std::optional<AssistPart> collect();

 private:
  mutable std::mutex mutex_;
  std::uint64_t version_ = 0;
  std::vector<std::shared_ptr<const AssistTask>> tasks_;  ///< newest last
  AssistNews news_;
  std::uint64_t held_ = 0, delivered_ = 0;
  bool in_transit_ = false;
  std::optional<AssistPart> part_;
};

/// A renderer for a Runner whose pictures are parts of films. Instead of showing a picture it hands
/// a part to the desk. So the policy schedules an assistant among the sessions of its device. The
/// progress it reports is that of the picture it assists.
class AssistRenderer final : public FrameRenderer {
 public:
  AssistRenderer(std::unique_ptr<FrameRenderer> own, std::shared_ptr<AssistDesk> desk)
      : own_(std::move(own)), desk_(std::move(desk)) {}

  Result<void> set_scene(const diaphane::v1::Scene& scene, Canvas canvas) override;
  Result<Batch> render(std::uint32_t samples, const std::function<bool()>& stop) override;
  Progress progress() const override;
  /// Hands a part to the desk. Leaves `out` unchanged.
  Result<void> display(PictureRgb8& out) override;
  Result<void> radiance(PictureRgbF&) override { return no_picture(); }
  Result<void> contents(std::vector<std::uint8_t>&) override { return no_picture(); }
  std::vector<std::string> features() const override { return own_->features(); }
  KernelReport report() const override { return own_->report(); }

 private:
  static tl::unexpected<Error> no_picture() {
    return fail(ErrorCode::kUnsupported, "an assisting worker does not show a picture");
  }

  std::unique_ptr<FrameRenderer> own_;
  std::shared_ptr<AssistDesk> desk_;
  std::shared_ptr<const AssistTask> task_;
  std::uint64_t drawn_ = 0, held_ = 0;
  double seconds_ = 0, held_seconds_ = 0;
};

}  // namespace diaphane::render
