#include "api/service/housekeeping.h"

#include <algorithm>
#include <exception>
#include <filesystem>

#include "common/ids.h"
#include "common/log.h"

namespace diaphane::api {
namespace {

constexpr int kMailsAtOnce = 20;
constexpr int kMailAttempts = 12;  ///< about 11 hours
constexpr auto kMailLease = std::chrono::minutes(2);
constexpr int kDisposalsAtOnce = 100;

}  // namespace

std::chrono::seconds Mailer::pause_after(int failures) {
  const int doublings = std::clamp(failures - 1, 0, 20);
  return std::min<std::chrono::seconds>(std::chrono::seconds(5LL << doublings),
                                        std::chrono::hours(1));
}

Mailer::Sent Mailer::send_due() {
  Sent total;
  for (int i = 0; i < kMailsAtOnce; ++i) {
    const auto next = store_.claim_mail(clock_.wall(), kMailLease);
    if (!next || !*next) break;
    const MailStore::Queued& queued = **next;
    const auto sent = transport_.send(queued.mail);
    if (sent) {
      ++total.sent;
      (void)store_.mail_sent(queued.id);
      continue;
    }
    ++total.failed;
    const int failures = queued.attempts + 1;
    const bool hopeless = sent.error().code == ErrorCode::kInvalid || failures >= kMailAttempts;
    log::warning("failed to send an email", {{"mail", queued.id},
                                             {"failures", failures},
                                             {"given_up", hopeless},
                                             {"reason", sent.error().message}});
    if (hopeless) {
      (void)store_.mail_sent(queued.id);
    } else {
      (void)store_.mail_failed(queued.id, clock_.wall() + pause_after(failures));
    }
  }
  return total;
}

int Disposer::dispose() {
  const auto due = store_.disposals(kDisposalsAtOnce);
  if (!due) return 0;
  int gone = 0;
  for (const Disposal& disposal : *due) {
    if (auto done = remove(disposal); !done) {
      log::warning("failed to delete files",
                   {{"id", disposal.id}, {"reason", done.error().message}});
      continue;
    }
    if (store_.disposed(disposal)) ++gone;
  }
  return gone;
}

Result<void> Disposer::remove(const Disposal& disposal) {
  if (!is_id(disposal.id)) return fail(ErrorCode::kInternal, "not a valid id");
  if (disposal.kind == Disposal::Kind::kUpload) return files_.remove(disposal.id);
  if (disposal.kind == Disposal::Kind::kPictures) return thumbnails_.remove(disposal.id);
  if (disposal.kind == Disposal::Kind::kPreset) return preset_pictures_.remove(disposal.id);
  std::error_code error;
  if (disposal.kind == Disposal::Kind::kExport) {
    std::filesystem::remove(export_directory_ + "/" + disposal.id + ".zip", error);
    if (error) return fail(ErrorCode::kUnavailable, "cannot delete the export");
    return {};
  }
  std::filesystem::remove_all(volume_directory_ + "/" + disposal.id, error);
  if (error) return fail(ErrorCode::kUnavailable, "cannot delete the volume");
  return thumbnails_.remove(disposal.id);
}

Periodic::Periodic(std::string name, std::chrono::milliseconds period, std::function<void()> work)
    : name_(std::move(name)), period_(period), work_(std::move(work)), thread_([this] { run(); }) {}

Periodic::~Periodic() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Periodic::wake() {
  {
    const std::lock_guard lock(mutex_);
    woken_ = true;
  }
  changed_.notify_all();
}

void Periodic::run() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    woken_ = false;
    lock.unlock();
    try {
      work_();
    } catch (const std::exception& thrown) {
      log::error("background task failed", {{"work", name_}, {"reason", log::describe(thrown)}});
    }
    lock.lock();
    changed_.wait_for(lock, period_, [this] { return stopping_ || woken_; });
  }
}

}  // namespace diaphane::api
