#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "api/presets/presets.h"
#include "api/scans/data_sets.h"
#include "api/shared/audit.h"
#include "common/clock.h"

namespace diaphane::api {

/// The reasons for a report: the item identifies a person, belongs to someone else, is offensive,
/// or another reason that the reporter describes.
inline constexpr std::array<std::string_view, 4> kReportReasons{"identifies", "not_theirs",
                                                                "offensive", "other"};

struct Report {
  std::string id;
  std::string data_set_id, title;
  std::string preset_id, preset_name;  ///< the reported preset; empty for the data set itself
  std::string reason;                  ///< one of kReportReasons
  std::string words;                   ///< the reporter's comment, or empty
  bool taken_down = false;             ///< the reported item is hidden
  Time created_at;
};

/// A scan or preset that an administrator has hidden.
struct TakeDown {
  std::string data_set_id, title;
  std::string preset_id, preset_name;  ///< empty for the data set itself
  std::string reason;                  ///< as the administrator wrote it
  Time taken_down_at;
};

/// Implemented by sharing/report_repository. Every function may return kUnavailable. Each is one
/// transaction, which includes its audit entry.
class ReportStore {
 public:
  virtual ~ReportStore() = default;
  /// Stores a report. It replaces an open report about the same item by the same user.
  virtual Result<void> report(const Report& report, const std::string& reporter_id) = 0;
  /// Returns the open reports, oldest first.
  virtual Result<std::vector<Report>> open(int limit, const AuditEntry& entry, Time now) = 0;
  /// Returns the number of open reports.
  virtual Result<int> count_open() = 0;
  /// Returns the hidden scans and presets, newest first, but no presets of data sets that
  /// administrators must not see.
  virtual Result<std::vector<TakeDown>> taken_down(int limit, const AuditEntry& entry,
                                                   Time now) = 0;
  /// Closes a report. Returns kNotFound if it is not open.
  virtual Result<void> close(const std::string& report_id, const AuditEntry& entry, Time now) = 0;
  /// Makes the data set private, removes all people and links, and closes its reports.
  virtual Result<void> take_down(const std::string& data_set_id, const std::string& reason,
                                 const AuditEntry& entry, Time now) = 0;
  /// Restores a data set. It stays private until its owner publishes it again. A sample becomes
  /// public.
  virtual Result<void> restore(const std::string& data_set_id, const AuditEntry& entry,
                               Time now) = 0;
  /// Hides a preset from everyone but its author and administrators, removes it as a default and
  /// closes its reports. Returns kNotFound.
  virtual Result<void> take_down_preset(const std::string& preset_id, const std::string& reason,
                                        const AuditEntry& entry, Time now) = 0;
  virtual Result<void> restore_preset(const std::string& preset_id, const AuditEntry& entry,
                                      Time now) = 0;
};

/// Reports of abuse and the actions of administrators on them. Thread-safe.
class Reports {
 public:
  Reports(DataSets& data_sets, Presets& presets, ReportStore& store, AccountStore& accounts,
          const Clock& clock, std::function<void(const std::string&)> end_lost_sessions);

  /// Reports a data set. A user can make 20 reports per day, including those of presets.
  Outcome<void> report(const Principal& who, const std::string& data_set_id,
                       const std::string& reason, const std::string& words);
  /// Reports the name of someone else's preset on a data set that can be reported.
  Outcome<void> report_preset(const Principal& who, const std::string& preset_id,
                              const std::string& reason, const std::string& words);
  /// Returns the open reports. Records the access in the audit log, as taken_down() does.
  Outcome<std::vector<Report>> open(const Principal& who);
  /// Returns the number of open reports. It reveals nothing about anyone, so it is not logged.
  Outcome<int> count_open();
  Outcome<std::vector<TakeDown>> taken_down(const Principal& who);
  Outcome<void> close(const Principal& who, const std::string& report_id);
  Outcome<void> take_down(const Principal& who, const std::string& data_set_id,
                          const std::string& reason);
  Outcome<void> restore(const Principal& who, const std::string& data_set_id);
  /// Both functions return kNotFound for a preset of a data set that administrators must not see.
  Outcome<void> take_down_preset(const Principal& who, const std::string& preset_id,
                                 const std::string& reason);
  Outcome<void> restore_preset(const Principal& who, const std::string& preset_id);

 private:
  Outcome<void> note(const Principal& who, Report report);
  /// Checks that an administrator may take down and restore the preset.
  Outcome<void> may_judge(const Principal& who, const std::string& preset_id);

  DataSets& data_sets_;
  Presets& presets_;
  ReportStore& store_;
  AccountStore& accounts_;
  const Clock& clock_;
  std::function<void(const std::string&)> end_lost_sessions_;
};

}  // namespace diaphane::api
