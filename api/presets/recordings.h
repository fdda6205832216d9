#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "api/accounts/accounts.h"
#include "common/clock.h"

namespace diaphane::api {

/// A user's recorded interaction with a scan (docs/contracts.md, "Recorded interaction").
struct Recording {
  std::string id;
  std::string body;  ///< the JSON document; empty in lists
  int events = 0;
  std::int64_t duration_ms = 0;
  Time created_at{}, expires_at{};
};

/// Implemented by presets/recording_repository. Every function may return kUnavailable.
class RecordingStore {
 public:
  virtual ~RecordingStore() = default;
  virtual Result<bool> consent(const std::string& user_id) = 0;
  virtual Result<void> set_consent(const std::string& user_id, bool given, Time now) = 0;
  /// Returns kForbidden without consent, or kTooLarge if the user would exceed `most_bytes`.
  virtual Result<void> add(const std::string& user_id, const Recording& recording,
                           std::int64_t most_bytes) = 0;
  /// Returns the recordings that have not expired, newest first and without bodies.
  virtual Result<std::vector<Recording>> of(const std::string& user_id, Time now) = 0;
  /// Returns kNotFound also for another user's recording.
  virtual Result<Recording> find(const std::string& user_id, const std::string& id, Time now) = 0;
  virtual Result<void> remove(const std::string& user_id, const std::string& id) = 0;
  virtual Result<void> expire(Time now) = 0;
};

/// Recorded interactions of users who consented. Thread-safe.
class Recordings {
 public:
  struct Mine {
    bool consent = false;
    std::vector<Recording> recordings;
  };

  static constexpr std::chrono::hours kLife{24 * 90};
  static constexpr std::int64_t kMostBytes = 20 * 1024 * 1024;  ///< per user

  Recordings(RecordingStore& store, const Clock& clock) : store_(store), clock_(clock) {}

  Outcome<Mine> list(const Principal& who);
  Outcome<void> give_consent(const Principal& who, bool given);
  /// Returns the ID of the new recording, kForbidden without consent, or kOverQuota.
  Outcome<std::string> add(const Principal& who, Recording recording);
  Outcome<Recording> find(const Principal& who, const std::string& id);
  Outcome<void> remove(const Principal& who, const std::string& id);

 private:
  RecordingStore& store_;
  const Clock& clock_;
};

}  // namespace diaphane::api
