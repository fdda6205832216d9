#pragma once

#include <functional>
#include <optional>
#include <string>

#include "api/scans/data_sets.h"
#include "common/clock.h"
#include "volume/alignment.h"

namespace diaphane::api {

/// How a second scan lies in the space of a first one. Both have the same axes, so the alignment of
/// two scans in the other order is the inverse.
struct Alignment {
  std::string state = "none";  ///< "none", "waiting", "running", "ready" or "failed"
  bool shares_frame = false;   ///< both have the same frame of reference, so they are "ready"
  /// In state "ready": from the patient coordinates (mm, LPS) of the second scan to those of the
  /// first.
  volume::Matrix matrix = volume::kIdentity;
  std::optional<double> residual_mm, overlap;  ///< of a computed alignment in state "ready"
  std::string reason;                          ///< in state "failed", a code
  // Set by Alignments.
  bool may_align = false;  ///< the requester owns one of the two scans
  /// Like `matrix`, from the world coordinates of the second picture to those of the first
  /// (api/proto/scene.proto). Absent if a volume cannot be read.
  std::optional<volume::Matrix> scene_matrix;
};

/// Every function returns kUnavailable if the database is unavailable.
class AlignmentStore {
 public:
  virtual ~AlignmentStore() = default;
  enum class Request { kMade, kKnown, kTooMany, kNotReady };
  virtual Result<Alignment> find(const std::string& first, const std::string& second) = 0;
  /// Queues an alignment with an audit entry, unless there is one that has not failed. Returns
  /// kTooMany if `most` alignments of this user are unfinished.
  virtual Result<Request> request(const std::string& user_id, const std::string& first,
                                  const std::string& second, int most, Time now) = 0;
  /// Deletes the alignment of two scans. Returns false if there is none.
  virtual Result<bool> remove(const std::string& first, const std::string& second) = 0;
};

/// Rigid alignments of two scans, which ingestd computes (ingest/registration/register.h). Whoever
/// may view both scans may see how they are aligned. Thread-safe.
class Alignments {
 public:
  /// Maximum number of unfinished alignments per account.
  static constexpr int kMostUnfinished = 4;
  struct Requested {
    Alignment alignment;
    bool made = false;  ///< it did not exist before
  };

  /// `header` returns the header of a stored volume.
  Alignments(DataSets& data_sets, AlignmentStore& store, const Clock& clock,
             std::function<Result<volume::Header>(const std::string& id)> header)
      : data_sets_(data_sets), store_(store), clock_(clock), header_(std::move(header)) {}

  /// Returns the alignment of two scans that the user may view. Returns kNotFound, kNotReady, or
  /// kConflict if both are the same.
  Outcome<Alignment> find(const Principal& who, const std::string& first,
                          const std::string& second);
  /// Requests an alignment. Returns also kForbidden unless the user owns one of the scans, and
  /// kTooMany.
  Outcome<Requested> request(const Principal& who, const std::string& first,
                             const std::string& second);
  Outcome<void> remove(const Principal& who, const std::string& first, const std::string& second);
  /// Returns the motion of two aligned scans as in PlaceRequest::to_first, or kNotAligned.
  Outcome<std::string> motion(const Principal& who, const std::string& first,
                              const std::string& second);

 private:
  /// Returns whether the user owns one of two scans that they may view.
  Outcome<bool> check(const Principal& who, const std::string& first, const std::string& second);

  DataSets& data_sets_;
  AlignmentStore& store_;
  const Clock& clock_;
  const std::function<Result<volume::Header>(const std::string&)> header_;
};

}  // namespace diaphane::api
