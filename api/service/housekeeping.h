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

/// Sends one mail. Implemented in api/mail.
class MailTransport {
 public:
  virtual ~MailTransport() = default;
  /// kUnavailable: worth trying again. kInvalid: the recipient is refused for good.
  virtual Result<void> send(const Mail& mail) = 0;
};

/// One look at the queue: sends what is due. Mails go out at least once.
class Mailer {
 public:
  Mailer(MailStore& store, MailTransport& transport, const Clock& clock)
      : store_(store), transport_(transport), clock_(clock) {}
  struct Sent {
    int sent = 0, failed = 0;
  };
  Sent send_due();
  /// How long to wait after the n-th failure: 5 s, doubled each time, at most an hour.
  static std::chrono::seconds pause_after(int failures);

 private:
  MailStore& store_;
  MailTransport& transport_;
  const Clock& clock_;
};

/// Removes from disk what the database has noted; what fails is tried again at the next look.
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
  /// How many are gone now.
  int dispose();

 private:
  Result<void> remove(const Disposal& disposal);
  DataSetStore& store_;
  UploadFiles& files_;
  Thumbnails& thumbnails_;
  PresetPictures& preset_pictures_;
  std::string volume_directory_, export_directory_;
};

/// A thread that does one thing now and then, and at once when woken. What it throws is logged.
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
