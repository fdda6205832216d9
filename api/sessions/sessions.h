#pragma once

#include <functional>
#include <string>
#include <vector>

#include "api/scans/data_sets.h"
#include "api/sessions/render_time.h"
#include "api/shared/error_curves.h"
#include "api/shared/placement.h"
#include "api/shared/problem.h"

namespace diaphane::api {

/// Render sessions. They are stored only in Redis. Thread-safe.
class Sessions {
 public:
  struct Stream {
    std::string session_id;
    std::string stream_url;  ///< path and query on the page's origin; works once, within 30 s
  };

  /// Returns how the second of two data sets lies in the space of the first, as in
  /// PlaceRequest::to_first, or kNotAligned.
  using Motion = std::function<Outcome<std::string>(const Principal& who, const std::string& first,
                                                    const std::string& second)>;

  /// `first_scene` returns the initial scene of a new session on a data set (PlaceRequest).
  Sessions(DataSets& data_sets, Placement& placement, RenderTime& render_time,
           ErrorCurves& error_curves,
           std::function<std::string(const std::string& data_set_id)> first_scene, Motion motion)
      : data_sets_(data_sets),
        placement_(placement),
        render_time_(render_time),
        error_curves_(error_curves),
        first_scene_(std::move(first_scene)),
        motion_(std::move(motion)) {}

  /// Opens a session on a data set. `over` is the data set that it shows over this one, or empty.
  /// Returns kNotFound or kNotReady (the data sets), kNotAligned, kInvalid, kNoWorker, kUnavailable
  /// (Redis), kTooMany, kRenderTimeSpent, kIdempotencyKeyReused, or kUnauthenticated if the browser
  /// was signed out in the meantime.
  Outcome<Stream> open(const Principal& who, const std::string& data_set_id,
                       const std::string& over, const std::string& idempotency_key);
  Outcome<std::vector<SessionInfo>> list(const Principal& who);
  /// Returns the user's session. Returns kNotFound also for another user's session.
  Outcome<SessionInfo> find(const Principal& who, const std::string& id);
  Outcome<void> end(const Principal& who, const std::string& id);
  /// Returns a new ticket. Places the session on another worker if its worker is gone.
  Outcome<Stream> ticket(const Principal& who, const std::string& id);

  /// Returns the session's error curve, which has no points before the first picture.
  Outcome<ErrorCurve> error_curve(const Principal& who, const std::string& id);

 private:
  /// The data sets of a session, which the user may view: one, or two.
  using Shown = std::vector<DataSet>;

  Outcome<Shown> find_shown(const Principal& who, const std::string& data_set_id,
                            const std::string& over);
  Outcome<Stream> place(const Principal& who, const std::string& session_id, const Shown& shown,
                        const std::string& to_first);
  Outcome<void> check_and_note(const Principal& who, const std::string& session_id,
                               const Shown& shown);

  DataSets& data_sets_;
  Placement& placement_;
  RenderTime& render_time_;
  ErrorCurves& error_curves_;
  const std::function<std::string(const std::string&)> first_scene_;
  const Motion motion_;
};

}  // namespace diaphane::api
