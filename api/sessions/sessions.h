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

  /// `first_scene` returns the initial scene of a new session on a data set (PlaceRequest).
  Sessions(DataSets& data_sets, Placement& placement, RenderTime& render_time,
           ErrorCurves& error_curves,
           std::function<std::string(const std::string& data_set_id)> first_scene)
      : data_sets_(data_sets),
        placement_(placement),
        render_time_(render_time),
        error_curves_(error_curves),
        first_scene_(std::move(first_scene)) {}

  /// Opens a session on a data set. Returns kNotFound or kNotReady (the data set), kNoWorker,
  /// kUnavailable (Redis), kTooMany, kRenderTimeSpent, kIdempotencyKeyReused, or kUnauthenticated
  /// if the browser was signed out in the meantime.
  Outcome<Stream> open(const Principal& who, const std::string& data_set_id,
                       const std::string& idempotency_key);
  Outcome<std::vector<SessionInfo>> list(const Principal& who);
  /// Returns the user's session. Returns kNotFound also for another user's session.
  Outcome<SessionInfo> find(const Principal& who, const std::string& id);
  Outcome<void> end(const Principal& who, const std::string& id);
  /// Returns a new ticket. Places the session on another worker if its worker is gone.
  Outcome<Stream> ticket(const Principal& who, const std::string& id);

  /// Returns the session's error curve, which has no points before the first picture.
  Outcome<ErrorCurve> error_curve(const Principal& who, const std::string& id);

 private:
  Outcome<Stream> place(const Principal& who, const std::string& session_id,
                        const DataSet& data_set);

  DataSets& data_sets_;
  Placement& placement_;
  RenderTime& render_time_;
  ErrorCurves& error_curves_;
  const std::function<std::string(const std::string&)> first_scene_;
};

}  // namespace diaphane::api
