#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "renderd/composite/assistant.h"
#include "renderd/composite/plan.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

struct CompositeOptions {
  /// If empty, the division is chosen for each picture by its predicted time (plan.h).
  std::optional<Division> division;
  /// If false, parts of older pictures are merged too, as if epochs did not exist. They appear as
  /// ghosts (thesis 5.1.2). For the test that shows this.
  bool drop_older_epochs = true;
  /// How long to wait for bands of a first picture, in addition to the time they take. Afterwards
  /// the devices that respond render the missing rows.
  std::chrono::milliseconds patience{100};
};

/// Data transferred for a picture since its scene was set.
struct CompositeReport {
  Division division = Division::kAverage;
  std::uint64_t parts = 0;
  std::uint64_t dropped_parts = 0;  ///< parts of older epochs
  std::uint64_t bytes = 0;          ///< transferred, including dropped parts
  double merge_seconds = 0;
  std::size_t assistants = 0;  ///< number with a share now
};

/// Renders a picture on several devices. Its own renderer shows the picture and merges the parts of
/// the assistants, weighted by their numbers of samples. A lost assistant costs only its share: its
/// parts stay, and its rows, if it had some, go to the others. An assistant that comes back gets a
/// share again.
class CompositeRenderer final : public FrameRenderer {
 public:
  CompositeRenderer(std::unique_ptr<FrameRenderer> own,
                    std::vector<std::unique_ptr<Assistant>> assistants, CompositeOptions options,
                    std::size_t home = 0);

  Result<void> set_volume(std::shared_ptr<const DeviceVolume> volume) override;
  /// While a scene shows a second scan, only the own device renders it.
  Result<void> set_second(std::shared_ptr<const DeviceVolume> volume,
                          const volume::Matrix& to_first) override;
  Result<void> set_scene(const diaphane::v1::Scene& scene, Canvas canvas) override;
  Result<Batch> render(std::uint32_t samples, const std::function<bool()>& stop) override;
  Progress progress() const override;
  Result<void> display(PictureRgb8& out) override { return own_->display(out); }
  Result<void> radiance(PictureRgbF& out) override { return own_->radiance(out); }
  Result<void> contents(std::vector<std::uint8_t>& out) override { return own_->contents(out); }
  void prepare_denoising(bool enabled) override;
  void set_precedence(unsigned precedence) override { own_->set_precedence(precedence); }
  void raise_precedence(unsigned precedence) override { own_->raise_precedence(precedence); }
  Result<bool> display_denoised(PictureRgb8& out) override { return own_->display_denoised(out); }
  Result<bool> radiance_denoised(PictureRgbF& out) override { return own_->radiance_denoised(out); }
  std::vector<std::string> features() const override { return own_->features(); }
  KernelReport report() const override { return own_->report(); }

  const CompositeReport& composite() const { return report_; }

 private:
  /// An assistant and its state.
  struct Helper {
    std::unique_ptr<Assistant> assistant;
    std::optional<Share> share;  ///< empty if it has no share in this picture
    double speed = 0;            ///< pixel samples per second; 0 if unknown
    bool silent = false;         ///< delivered nothing in time, and has no share in this epoch
  };

  Division choose() const;
  /// Gives each device a share of the remaining work.
  Result<void> deal(Division division);
  /// Gives shares to new assistants and redistributes the rows of lost ones.
  Result<void> settle_changes();
  Result<void> absorb();
  Result<void> merge(Helper& helper, const AssistPart& part);
  Result<void> await_bands(const std::function<bool()>& stop);
  void learn_own(const Batch& batch);
  bool has_gaps() const;
  bool can_help(const Helper& helper) const {
    return !alone_ && !helper.silent && !helper.assistant->lost();
  }

  const std::unique_ptr<FrameRenderer> own_;
  const CompositeOptions options_;
  const std::size_t home_;  ///< device of `own_`
  std::vector<Helper> helpers_;
  std::shared_ptr<const CompositeVolume> next_volume_;  ///< AssistTask::volume of the next scene

  bool has_second_ = false;  ///< set_second()
  bool alone_ = false;       ///< the scene shows the second scan, which no assistant has

  AssistTask task_;  ///< task of this epoch, without the share
  std::uint64_t epoch_ = 0;
  std::uint64_t sequence_ = 0;  ///< sequence of the last shares dealt in this epoch
  Share own_share_;
  double own_speed_ = 0;
  bool guided_ = false;
  std::vector<std::uint64_t> drawn_;  ///< samples in the film, per kShareRows rows
  RowCosts costs_;
  double merge_seconds_per_pixel_ = 0;  ///< 0: unknown
  double turn_seconds_ = 0;             ///< duration of a call of render(); 0: unknown
  std::optional<Division> before_;      ///< division of the previous picture
  std::uint32_t own_extra_ = 0;         ///< samples beyond those requested in this call
  double helped_seconds_ = 0;           ///< device time of parts merged since the last batch
  /// Number of samples for an error of 5%, estimated from the last picture.
  mutable double samples_needed_ = 16;
  mutable double told_error_ = 0;  ///< error returned by the last progress()
  CompositeReport report_;
};

}  // namespace diaphane::render
