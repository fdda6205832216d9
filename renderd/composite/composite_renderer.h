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
  /// Nothing: chosen for each picture by what it gains (plan.h).
  std::optional<Division> division;
  /// False: parts of older pictures are merged too, as if nobody counted them. They are ghosts
  /// (thesis 5.1.2): for the test that shows it.
  bool drop_older_epochs = true;
  /// How long bands of a first picture are waited for, beside what they take; then their rows are
  /// rendered by those that answer.
  std::chrono::milliseconds patience{100};
};

/// What was moved for a picture, since its scene was set.
struct CompositeReport {
  Division division = Division::kAverage;
  std::uint64_t parts = 0;
  std::uint64_t dropped_parts = 0;  ///< of older epochs
  std::uint64_t bytes = 0;          ///< moved, dropped ones included
  double merge_seconds = 0;
  std::size_t assistants = 0;  ///< that have a share now
};

/// A picture that several devices render: its own renderer shows it and merges what assistants
/// deliver, by numbers of samples. Whoever is lost costs its share, no more: its parts stay, and
/// its rows, if it had some of its own, go to the others. Whoever comes back gets a share.
class CompositeRenderer final : public FrameRenderer {
 public:
  CompositeRenderer(std::unique_ptr<FrameRenderer> own,
                    std::vector<std::unique_ptr<Assistant>> assistants, CompositeOptions options);

  Result<void> set_scene(const diaphane::v1::Scene& scene, Canvas canvas) override;
  Result<Batch> render(std::uint32_t samples, const std::function<bool()>& stop) override;
  Progress progress() const override;
  Result<void> display(PictureRgb8& out) override { return own_->display(out); }
  Result<void> radiance(PictureRgbF& out) override { return own_->radiance(out); }
  Result<void> contents(std::vector<std::uint8_t>& out) override { return own_->contents(out); }
  void prepare_denoising(bool wanted) override;
  void hurry(bool urgent) override { own_->hurry(urgent); }
  Result<bool> display_denoised(PictureRgb8& out) override { return own_->display_denoised(out); }
  Result<bool> radiance_denoised(PictureRgbF& out) override { return own_->radiance_denoised(out); }
  std::vector<std::string> features() const override { return own_->features(); }
  KernelReport report() const override { return own_->report(); }

  const CompositeReport& composite() const { return report_; }

 private:
  /// An assistant, and what is known of it.
  struct Helper {
    std::unique_ptr<Assistant> assistant;
    std::optional<Share> share;  ///< nothing: it has none in this picture
    double speed = 0;            ///< pixels' samples a second; 0: unknown
    bool silent = false;         ///< it delivered nothing in time: without a share in this epoch
  };

  Division choose() const;
  /// Gives everybody a share of what is rendered from now on.
  Result<void> deal(Division division);
  /// Shares for who came, and for the rows of who went.
  Result<void> settle_changes();
  Result<void> absorb();
  Result<void> merge(Helper& helper, const AssistPart& part);
  Result<void> await_bands(const std::function<bool()>& stop);
  void learn_own(const Batch& batch);
  bool has_gaps() const;
  bool can_help(const Helper& helper) const { return !helper.silent && !helper.assistant->lost(); }

  const std::unique_ptr<FrameRenderer> own_;
  const CompositeOptions options_;
  std::vector<Helper> helpers_;

  AssistTask task_;  ///< of this epoch, but for the share
  std::uint64_t epoch_ = 0;
  std::uint64_t sequence_ = 0;  ///< of the last shares dealt in this epoch
  Share own_share_;
  double own_speed_ = 0;
  bool guided_ = false;
  std::vector<std::uint64_t> drawn_;  ///< samples that the film has, each kShareRows rows
  RowCosts costs_;
  double merge_seconds_per_pixel_ = 0;  ///< 0: unknown
  double turn_seconds_ = 0;             ///< of a call of render(); 0: unknown
  std::optional<Division> before_;      ///< of the picture before this one
  std::uint32_t own_extra_ = 0;         ///< samples beyond those asked for, in this call
  double helped_seconds_ = 0;           ///< by devices whose parts were merged since the last batch
  mutable double samples_needed_ = 16;  ///< to 5%, as the last picture was seen to need
  mutable double told_error_ = 0;       ///< of the last progress()
  CompositeReport report_;
};

}  // namespace diaphane::render
