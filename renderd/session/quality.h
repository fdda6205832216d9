#pragma once

#include "api/proto/stream.pb.h"
#include "renderd/film/canvas.h"
#include "renderd/session/link.h"

namespace diaphane::render {

/// What a viewer's connection permits.
struct QualityPlan {
  double moving_scale = 1;          ///< maximum size of a moving picture, relative to the
                                    ///< viewport's sides
  std::uint32_t moving_bytes = 0;   ///< approximate limit for a moving frame
  std::uint32_t settled_bytes = 0;  ///< limit for a settled frame; lossless tiles have none
  std::uint64_t window_bytes = 0;   ///< another message may be sent while fewer bytes are in
                                    ///< transit
  std::uint64_t window_frames = 2;  ///< limit for frames being encoded or in transit
};

/// Chooses a quality step from the estimated capacity. It steps down at once, but up only after a
/// second with a margin, so that the picture does not flicker between two steps. Takes the time as
/// an argument.
class QualitySteps {
 public:
  using Time = LinkEstimate::Time;

  const QualityPlan& update(const LinkEstimate& link, Canvas viewport, diaphane::v1::Codec codec,
                            Time now);
  const QualityPlan& plan() const { return plan_; }

 private:
  QualityPlan plan_{1, 0, 0, ~std::uint64_t{0}, 2};
  std::size_t step_ = 0;
  Time fits_since_{};  // since when the next better step has fitted; zero: it does not fit
};

}  // namespace diaphane::render
