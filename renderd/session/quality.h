#pragma once

#include "api/proto/stream.pb.h"
#include "renderd/film/canvas.h"
#include "renderd/session/link.h"

namespace diaphane::render {

/// What a viewer's connection permits.
struct QualityPlan {
  double moving_scale = 1;          ///< largest share of the viewport's sides for a moving picture
  std::uint32_t moving_bytes = 0;   ///< approximate limit for a moving frame
  std::uint32_t settled_bytes = 0;  ///< limit for a settled frame; lossless tiles have none
  std::uint64_t window_bytes = 0;   ///< another message may follow while fewer are in transit
  std::uint64_t window_frames = 2;  ///< limit for frames being encoded or in transit
};

/// Chooses a quality step by the estimated capacity. It steps down at once, and up after a while
/// and with a margin, so that the picture does not flicker between two steps. Pure apart from the
/// current step.
class QualitySteps {
 public:
  using Time = LinkEstimate::Time;

  const QualityPlan& update(const LinkEstimate& link, Canvas viewport, diaphane::v1::Codec codec,
                            Time now);
  const QualityPlan& plan() const { return plan_; }

 private:
  QualityPlan plan_{1, 0, 0, ~std::uint64_t{0}, 2};
  std::size_t step_ = 0;
  Time fits_since_{};  // since when a better step has fitted; zero: it does not fit
};

}  // namespace diaphane::render
