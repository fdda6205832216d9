#pragma once

#include "api/proto/stream.pb.h"
#include "renderd/film/canvas.h"
#include "renderd/session/link.h"

namespace diaphane::render {

/// What a viewer's connection allows.
struct QualityPlan {
  double moving_scale = 1;          ///< of the viewport's sides, of a moving picture, at most
  std::uint32_t moving_bytes = 0;   ///< of a moving frame, at most about
  std::uint32_t settled_bytes = 0;  ///< of a settled one; the lossless end has no bound
  std::uint64_t window_bytes = 0;   ///< on the way when another message may follow
  std::uint64_t window_frames = 2;  ///< being coded or on the way, at most
};

/// Steps of the quality, chosen by what the link carries: down at once, up after a while with a
/// margin, so that a picture does not flicker between two. Pure but for the step it is on.
class QualitySteps {
 public:
  using Time = LinkEstimate::Time;

  const QualityPlan& update(const LinkEstimate& link, Canvas viewport, diaphane::v1::Codec codec,
                            Time now);
  const QualityPlan& plan() const { return plan_; }

 private:
  QualityPlan plan_{1, 0, 0, ~std::uint64_t{0}, 2};
  std::size_t step_ = 0;
  Time fits_since_{};  // a better step has fitted since then; zero: it does not
};

}  // namespace diaphane::render
