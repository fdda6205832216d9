#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/accounts/accounts.h"
#include "api/shared/signals.h"
#include "common/clock.h"

namespace diaphane::api {

/// An export of all data about a user: one zip file, which is kept for a day.
struct Export {
  enum class State { kQueued, kReady, kFailed };
  std::string id;
  State state = State::kQueued;
  std::int64_t bytes = 0;  ///< size, once it is ready
  Time created_at, expires_at;
  bool waiting = false;  ///< in state kQueued: there is not enough disk space at the moment
};

/// The rows of one table as a JSON array.
struct ExportSection {
  std::string name;
  std::string json;
};

/// Every function returns kUnavailable if the database is unavailable.
class ExportStore {
 public:
  struct Job {
    std::string id, user_id;
    int waits = 0;  ///< number of consecutive waits
  };
  /// The sizes that decide whether an export fits.
  struct Sizes {
    /// Size of the user's volumes, which make up nearly all of the export.
    std::int64_t volumes = 0;
    std::int64_t kept = 0;  ///< size of all exports that are ready, and of those of scans
  };
  virtual ~ExportStore() = default;
  /// Replaces the user's existing export. Returns false if that one did not fail and was created
  /// after `not_since`.
  virtual Result<bool> request(const std::string& user_id, const Export& requested,
                               Time not_since) = 0;
  virtual Result<std::optional<Export>> find(const std::string& user_id, Time now) = 0;
  /// Deletes the user's export. Returns false if there is none.
  virtual Result<bool> remove(const std::string& user_id, Time now) = 0;
  /// Claims the next queued export for `lease`. It fails permanently after three attempts.
  virtual Result<std::optional<Job>> claim(Time now, std::chrono::seconds lease) = 0;
  /// Returns all database records about the user, table by table, without secrets.
  virtual Result<std::vector<ExportSection>> sections(const std::string& user_id) = 0;
  virtual Result<std::vector<std::string>> volumes(const std::string& user_id) = 0;
  /// A thumbnail of one of the user's data sets with a preset by any author.
  struct Picture {
    std::string data_set_id, preset_id;
  };
  virtual Result<std::vector<Picture>> pictures(const std::string& user_id) = 0;
  virtual Result<std::vector<std::string>> environments(const std::string& user_id) = 0;
  /// Records a download in the audit log, at most once per hour, and in the view log of each scan
  /// in the export.
  virtual Result<void> note_download(const std::string& user_id, const Client& client,
                                     Time now) = 0;
  /// Marks the export as ready. Returns false if it was deleted in the meantime.
  virtual Result<bool> finish(const std::string& id, std::int64_t bytes) = 0;
  virtual Result<Sizes> sizes(const std::string& user_id) = 0;
  /// Returns a queued export to the queue until `not_before`. The attempt does not count.
  virtual Result<void> wait(const std::string& id, Time not_before) = 0;
  virtual Result<void> expire(Time now) = 0;
  /// Returns the IDs of all exports of accounts and of scans.
  virtual Result<std::vector<std::string>> ids() = 0;
};

/// An archive that is written entry by entry. Implemented in api/archive.
class ExportFile {
 public:
  virtual ~ExportFile() = default;
  virtual Result<void> add(const std::string& name, std::string_view text) = 0;
  virtual Result<void> add_file(const std::string& name, const std::string& path) = 0;
  /// Completes the file and returns its size in bytes.
  virtual Result<std::int64_t> finish() = 0;
};

/// Creates the exports of users and reports their state. Thread-safe.
class Exports {
 public:
  using MakeFile = std::function<Result<std::unique_ptr<ExportFile>>(const std::string& path)>;
  static constexpr std::chrono::hours kLife{24};
  static constexpr std::chrono::minutes kPause{10};  ///< minimum time between two exports of a user
  static constexpr std::chrono::minutes kLease{30};
  static constexpr std::chrono::seconds kFirstPause{2};  ///< doubles with each wait
  static constexpr std::chrono::seconds kLongestPause{120};

  struct Options {
    std::string volumes;             ///< directory
    std::string pictures;            ///< directory with one folder per preset
    std::string exports;             ///< directory
    std::int64_t reserve_bytes = 0;  ///< space to keep free on the disk of `exports`
    std::int64_t total_bytes = 0;    ///< maximum size of all exports; a single one may be larger
  };
  Exports(ExportStore& store, MakeFile make_file, const Clock& clock, const Signals& signals,
          Options options);

  /// Requests an export. Returns kTooMany within kPause of the previous request.
  Outcome<Export> request(const Principal& who);
  /// Returns the user's export, or kNotFound if there is none.
  Outcome<Export> find(const Principal& who);
  Outcome<void> remove(const Principal& who);
  /// Records the download and returns the file name in the export directory, kNotReady or
  /// kNotFound.
  Outcome<std::string> file(const Principal& who);

  /// Creates due exports and deletes old ones. An export without enough disk space waits, and its
  /// partial file is removed.
  void poll();

 private:
  Result<void> make(const ExportStore::Job& job);
  /// Deletes files whose export no longer exists. Returns false if the exports are unknown because
  /// the database did not answer.
  bool sweep();
  Result<void> check_room(const ExportStore::Job& job) const;
  Result<std::int64_t> write(const ExportStore::Job& job, const std::string& path);

  ExportStore& store_;
  MakeFile make_file_;
  const Clock& clock_;
  const Signals& signals_;
  Options options_;
  Time next_sweep_{};
};

}  // namespace diaphane::api
