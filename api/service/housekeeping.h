#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "api/service/account_store.h"
#include "api/service/data_set_store.h"
#include "api/service/preset_pictures.h"
#include "api/service/thumbnails.h"
#include "api/service/uploads.h"
#include "common/clock.h"

namespace diaphane::api {

/// Sends one email. Implemented in api/mail.
class MailTransport {
 public:
  virtual ~MailTransport() = default;
  /// Returns kUnavailable if a retry makes sense and kInvalid if the recipient is rejected
  /// permanently.
  virtual Result<void> send(const Mail& mail) = 0;
};

/// Polls the queue once and sends the due emails. Each email is sent at least once.
class Mailer {
 public:
  Mailer(MailStore& store, MailTransport& transport, const Clock& clock)
      : store_(store), transport_(transport), clock_(clock) {}
  struct Sent {
    int sent = 0, failed = 0;
  };
  Sent send_due();
  /// Delay after the n-th failure: 5 s, doubled each time, at most one hour.
  static std::chrono::seconds pause_after(int failures);

 private:
  MailStore& store_;
  MailTransport& transport_;
  const Clock& clock_;
};

/// Deletes the files that the database has queued for deletion. Failures are retried in the next
/// run.
class Disposer {
 public:
  Disposer(DataSetStore& store, UploadFiles& files, Thumbnails& thumbnails,
           PresetPictures& preset_pictures, std::string volume_directory,
           std::string export_directory)
      : store_(store),
        files_(files),
        thumbnails_(thumbnails),
        preset_pictures_(preset_pictures),
        volume_directory_(std::move(volume_directory)),
        export_directory_(std::move(export_directory)) {}
  /// Returns the number of deleted items.
  int dispose();

 private:
  Result<void> remove(const Disposal& disposal);
  DataSetStore& store_;
  UploadFiles& files_;
  Thumbnails& thumbnails_;
  PresetPictures& preset_pictures_;
  std::string volume_directory_, export_directory_;
};

/// A thread that runs a task periodically, and immediately when woken. Exceptions are logged.
class Periodic {
 public:
  Periodic(std::string name, std::chrono::milliseconds period, std::function<void()> work);
  ~Periodic();
  void wake();

 private:
  void run();
  const std::string name_;
  const std::chrono::milliseconds period_;
  const std::function<void()> work_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool woken_ = false;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace diaphane::api
