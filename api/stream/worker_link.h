#pragma once

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <string>

#include "api/proto/worker.grpc.pb.h"
#include "api/shared/placement.h"

namespace diaphane::api::stream {

/// Events from a link to its connection. They are called on gRPC threads, messages one at a time,
/// and never after on_link_ended.
class LinkEvents {
 public:
  virtual ~LinkEvents() = default;
  /// The call to the worker is established.
  virtual void on_link_open() = 0;
  /// Delivers a serialised ServerMessage. At most WorkerLink::kMostUndelivered arrive before
  /// delivered() is called.
  virtual void on_link_message(std::string message) = 0;
  /// Signals that messages can be sent again after send() returned false.
  virtual void on_link_writable() = 0;
  /// Reports the end of the call. This is the last event.
  virtual void on_link_ended(const grpc::Status& status) = 0;
};

/// One Attach call, which forwards messages between a viewer and its render worker without parsing
/// them. Applies back-pressure in both directions: it reads from the worker only as fast as the
/// viewer reads, and signals when the worker is full. Keeps itself alive until the call ends.
/// Thread-safe and non-blocking.
class WorkerLink final
    : public grpc::ClientBidiReactor<diaphane::v1::AttachRequest, diaphane::v1::AttachReply> {
 public:
  /// Messages read from the worker but not yet written to the viewer.
  static constexpr std::size_t kMostUndelivered = 3;
  /// Messages of the viewer not yet sent to the worker.
  static constexpr std::size_t kMostUnsent = 16;

  /// Starts the call with Open.
  static std::shared_ptr<WorkerLink> open(const std::shared_ptr<grpc::Channel>& channel,
                                          const Attachment& attachment,
                                          std::weak_ptr<LinkEvents> events);

  /// Sends a serialised ClientMessage. If it returns false, the caller must stop reading from the
  /// viewer until on_link_writable.
  bool send(std::string client_message);
  /// Reports that a message was written to the viewer, so that another one may be read.
  void delivered();
  /// Ends sending. Messages in the queue are still sent, then the worker ends the call.
  void finish();
  /// Ends the call immediately.
  void cancel();

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnWritesDoneDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;

 private:
  WorkerLink(const std::shared_ptr<grpc::Channel>& channel, std::weak_ptr<LinkEvents> events);
  /// The next operation on the call after a state change. It must run without the lock, because
  /// gRPC may call back from within.
  enum class Step { kNone, kWrite, kWritesDone, kRelease };
  Step next_write();  // requires the lock
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
  bool open_ = false;     // Open was written
  bool reading_ = false;  // a read is in progress
  bool reads_ended_ = false;
  bool writing_ = false;         // a write is in progress
  bool finishing_ = false;       // finish() was called
  bool writes_ended_ = false;    // writing has ended
  bool back_pressured_ = false;  // send() returned false
  bool released_ = false;        // the hold that keeps the call open for writes is released
};

}  // namespace diaphane::api::stream
