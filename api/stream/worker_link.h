#pragma once

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <string>

#include "api/proto/worker.grpc.pb.h"
#include "api/service/placement.h"

namespace diaphane::api::stream {

/// What a link tells the connection that it serves. Called on gRPC's threads, one call at a time
/// for messages, never after on_link_ended.
class LinkEvents {
 public:
  virtual ~LinkEvents() = default;
  /// The worker took the call.
  virtual void on_link_open() = 0;
  /// A serialised ServerMessage. No more than WorkerLink::kMostUndelivered come before delivered()
  /// is called.
  virtual void on_link_message(std::string message) = 0;
  /// There is room for messages again after send() said that there is none.
  virtual void on_link_writable() = 0;
  /// Last of all.
  virtual void on_link_ended(const grpc::Status& status) = 0;
};

/// One Attach call: messages of one viewer to and from its render worker, unread. Bounded both
/// ways: it reads no more from the worker than the viewer takes, and says when no more may be sent
/// to the worker. It holds itself until the call is over. Thread-safe; nothing blocks.
class WorkerLink final
    : public grpc::ClientBidiReactor<diaphane::v1::AttachRequest, diaphane::v1::AttachReply> {
 public:
  /// Messages read and not yet written to the viewer.
  static constexpr std::size_t kMostUndelivered = 3;
  /// Messages of the viewer not yet with the worker.
  static constexpr std::size_t kMostUnsent = 16;

  /// Begins the call with Open.
  static std::shared_ptr<WorkerLink> open(const std::shared_ptr<grpc::Channel>& channel,
                                          const Attachment& attachment,
                                          std::weak_ptr<LinkEvents> events);

  /// Sends a serialised ClientMessage. False: stop reading from the viewer until on_link_writable.
  bool send(std::string client_message);
  /// The viewer has got one of the messages: one more may be read.
  void delivered();
  /// No more is sent: what was sent goes out still, then the worker ends the call.
  void finish();
  /// Ends the call now.
  void cancel();

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnWritesDoneDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;

 private:
  WorkerLink(const std::shared_ptr<grpc::Channel>& channel, std::weak_ptr<LinkEvents> events);
  /// What is to be started on the call after a change of state; carried out without the lock,
  /// because gRPC may call back from within.
  enum class Step { kNone, kWrite, kWritesDone, kRelease };
  Step next_write();  // under the lock
  void carry_out(Step step);

  std::unique_ptr<diaphane::v1::RenderWorker::Stub> stub_;
  grpc::ClientContext context_;
  std::weak_ptr<LinkEvents> events_;
  std::shared_ptr<WorkerLink> self_;

  diaphane::v1::AttachReply reply_;
  diaphane::v1::AttachRequest request_;

  std::mutex mutex_;
  std::deque<std::string> unsent_;
  std::size_t undelivered_ = 0;
  bool open_ = false;     // the worker took Open
  bool reading_ = false;  // a read is with gRPC
  bool reads_ended_ = false;
  bool writing_ = false;       // a write is with gRPC
  bool finishing_ = false;     // finish() was called
  bool writes_ended_ = false;  // nothing is written any more
  bool told_full_ = false;     // send() said false
  bool released_ = false;      // the hold that keeps the call open for writes
};

}  // namespace diaphane::api::stream
