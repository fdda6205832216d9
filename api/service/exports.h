#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/service/accounts.h"
#include "common/clock.h"

namespace diaphane::api {

/// All that is held of a person as one zip file, made by a job and kept for a day.
struct Export {
  enum class State { kQueued, kReady, kFailed };
  std::string id;
  State state = State::kQueued;
  std::int64_t bytes = 0;  ///< when it is ready
  Time created_at, expires_at;
  bool waiting = false;  ///< with kQueued: there is no room for it just now
};

/// Rows of one table, as a JSON array.
struct ExportSection {
  std::string name;
  std::string json;
};

/// Every function: kUnavailable when the database is away.
class ExportStore {
 public:
  struct Job {
    std::string id, user_id;
    int waits = 0;  ///< how often in a row it has waited
  };
  /// What counts when an export is to be made.
  struct Sizes {
    std::int64_t volumes = 0;  ///< bytes of the person's own, which is nearly all that goes into it
    std::int64_t kept = 0;     ///< bytes of all exports that are ready
  };
  virtual ~ExportStore() = default;
  /// In place of the one that there is; nothing when that one is on its way, or was made after
  /// `not_since`.
  virtual Result<bool> request(const std::string& user_id, const Export& wanted,
                               Time not_since) = 0;
  virtual Result<std::optional<Export>> find(const std::string& user_id, Time now) = 0;
  /// False: there was none.
  virtual Result<bool> remove(const std::string& user_id, Time now) = 0;
  /// The next that is to be made, nobody else's for `lease`; given up after three times.
  virtual Result<std::optional<Job>> claim(Time now, std::chrono::seconds lease) = 0;
  /// Whatever the database holds of the person, table by table, but for secrets.
  virtual Result<std::vector<ExportSection>> sections(const std::string& user_id) = 0;
  virtual Result<std::vector<std::string>> volumes(const std::string& user_id) = 0;
  /// Those of presets, whoever saved them, that show the person's own data sets.
  struct Picture {
    std::string data_set_id, preset_id;
  };
  virtual Result<std::vector<Picture>> pictures(const std::string& user_id) = 0;
  /// False: it is not wanted any more.
  virtual Result<bool> finish(const std::string& id, std::int64_t bytes) = 0;
  virtual Result<Sizes> sizes(const std::string& user_id) = 0;
  /// Back into the queue until `not_before`; the attempt does not count.
  virtual Result<void> wait(const std::string& id, Time not_before) = 0;
  virtual Result<void> expire(Time now) = 0;
};

class ExportFile {
 public:
  virtual ~ExportFile() = default;
  virtual Result<void> add(const std::string& name, std::string_view text) = 0;
  virtual Result<void> add_file(const std::string& name, const std::string& path) = 0;
  /// Its size.
  virtual Result<std::int64_t> finish() = 0;
};

/// Thread-safe.
class Exports {
 public:
  using MakeFile = std::function<Result<std::unique_ptr<ExportFile>>(const std::string& path)>;
  static constexpr std::chrono::hours kLife{24};
  static constexpr std::chrono::minutes kPause{10};  ///< between two of one person
  static constexpr std::chrono::minutes kLease{30};
  static constexpr std::chrono::seconds kFirstPause{2};  ///< doubled each time it has to wait
  static constexpr std::chrono::seconds kLongestPause{120};

  struct Options {
    std::string volumes;             ///< directory
    std::string pictures;            ///< directory, with a folder for each preset
    std::string exports;             ///< directory
    std::int64_t reserve_bytes = 0;  ///< of the disk of `exports`, stay free
    std::int64_t total_bytes = 0;    ///< of all exports that are kept; one alone may be larger
  };
  Exports(ExportStore& store, MakeFile make_file, const Clock& clock, Options options);

  /// kTooMany soon after another.
  Outcome<Export> request(const Principal& who);
  /// kNotFound: there is none.
  Outcome<Export> find(const Principal& who);
  Outcome<void> remove(const Principal& who);
  /// The file's name in the export directory; kNotReady, kNotFound.
  Outcome<std::string> file(const Principal& who);

  /// Makes those that are due, and lets old ones go. One for which there is no room waits; nothing
  /// is left of what was begun.
  void look();
  void on_request(std::function<void()> wake) { wake_ = std::move(wake); }

 private:
  Result<void> make(const ExportStore::Job& job);
  Result<void> check_room(const ExportStore::Job& job) const;
  Result<std::int64_t> write(const ExportStore::Job& job, const std::string& path);

  ExportStore& store_;
  MakeFile make_file_;
  const Clock& clock_;
  Options options_;
  std::function<void()> wake_ = [] {};
};

}  // namespace diaphane::api
