#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "renderd/composite/assistant.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// Where an assistant's connection and its renderer meet. Thread-safe.
class AssistDesk {
 public:
  /// The newest task, numbered from 1; 0 and null: none yet.
  struct Order {
    std::uint64_t version = 0;
    std::shared_ptr<const AssistTask> task;
  };

  void put(AssistTask task);
  Order newest() const;
  /// The task whose scene this is, by its place in memory, while the runner may still ask for it.
  std::shared_ptr<const AssistTask> of(const diaphane::v1::Scene& scene) const;

  /// The compositor took the part; how far its picture is.
  void taken(const AssistNews& news);
  AssistNews news() const;
  /// No part is on its way.
  bool room() const;
  /// Whether rendering on is of use: not while twice what was delivered waits.
  bool wants_more() const;

  // Of the renderer.
  void began(const AssistTask& task);
  void drew(std::uint64_t held);
  void hand_over(AssistPart part);
  /// What hand_over() got, once.
  std::optional<AssistPart> collect();

 private:
  mutable std::mutex mutex_;
  std::uint64_t version_ = 0;
  std::vector<std::shared_ptr<const AssistTask>> tasks_;  ///< the newest last
  AssistNews news_;
  std::uint64_t held_ = 0, delivered_ = 0;
  bool on_its_way_ = false;
  std::optional<AssistPart> part_;
};

/// A renderer for a Runner whose pictures are parts of films: where the runner would have a picture
/// shown, a part goes to the desk. So an assistant gets its turns among the sessions of its device
/// by the same policy. Its progress is that of the picture that it helps with.
class AssistRenderer final : public FrameRenderer {
 public:
  AssistRenderer(std::unique_ptr<FrameRenderer> own, std::shared_ptr<AssistDesk> desk)
      : own_(std::move(own)), desk_(std::move(desk)) {}

  Result<void> set_scene(const diaphane::v1::Scene& scene, Canvas canvas) override;
  Result<Batch> render(std::uint32_t samples, const std::function<bool()>& stop) override;
  Progress progress() const override;
  /// Nothing is put into `out`.
  Result<void> display(PictureRgb8& out) override;
  Result<void> radiance(PictureRgbF&) override { return no_picture(); }
  Result<void> contents(std::vector<std::uint8_t>&) override { return no_picture(); }
  std::vector<std::string> features() const override { return own_->features(); }
  KernelReport report() const override { return own_->report(); }

 private:
  static tl::unexpected<Error> no_picture() {
    return fail(ErrorCode::kUnsupported, "an assistant has no picture of its own");
  }

  std::unique_ptr<FrameRenderer> own_;
  std::shared_ptr<AssistDesk> desk_;
  std::shared_ptr<const AssistTask> task_;
  std::uint64_t drawn_ = 0, held_ = 0;
  double seconds_ = 0, held_seconds_ = 0;
};

}  // namespace diaphane::render
