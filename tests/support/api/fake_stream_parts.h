#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "api/proto/worker.grpc.pb.h"
#include "api/shared/placement.h"
#include "api/shared/workers.h"
#include "common/ids.h"

// Replacements for Redis and renderd in tests of the gateway, which produce faults on demand.
namespace diaphane::api::stream {

/// Tickets, sessions and workers in memory.
class FakePlaces final : public Placement, public Tickets, public Workers {
 public:
  /// Issues a ticket for a session of `user` on the worker at `address`.
  std::string issue(const std::string& address, const std::string& user = new_id()) {
    const std::lock_guard lock(mutex_);
    Attachment attachment;
    attachment.session = {new_id(), user, new_id(), "worker"};
    attachment.address = address;
    attachment.incarnation = "one";
    attachment.placement = 7;
    sessions_[attachment.session.id] = attachment.session;
    const std::string ticket = random_hex(32);
    tickets_.emplace(ticket, attachment);
    return ticket;
  }
  void change(const std::string& ticket, const std::function<void(Attachment&)>& change) {
    const std::lock_guard lock(mutex_);
    change(tickets_.at(ticket));
  }
  void move_all_sessions_to(const std::string& worker) {
    const std::lock_guard lock(mutex_);
    for (auto& [id, session] : sessions_) session.worker_id = worker;
  }
  void end_all_sessions() {
    const std::lock_guard lock(mutex_);
    sessions_.clear();
  }
  void set_away(bool away) { away_ = away; }
  void set_alive(bool alive) { alive_ = alive; }
  std::vector<std::string> lost_workers() {
    const std::lock_guard lock(mutex_);
    return lost_;
  }

  Result<Attachment> consume(std::string_view ticket) override {
    const std::lock_guard lock(mutex_);
    if (away_) return fail(ErrorCode::kUnavailable, "away");
    const auto found = tickets_.find(std::string(ticket));
    if (found == tickets_.end()) return fail(ErrorCode::kUnauthenticated, "no such ticket");
    Attachment attachment = found->second;
    tickets_.erase(found);
    if (!sessions_.contains(attachment.session.id)) return fail(ErrorCode::kNotFound, "gone");
    return attachment;
  }
  Result<std::vector<std::string>> ended_links(const std::vector<std::string>& links) override {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> ended;
    for (const std::string& link : links) {
      if (ended_.contains(link)) ended.push_back(link);
    }
    return ended;
  }
  void end_link(const std::string& link) {
    const std::lock_guard lock(mutex_);
    ended_.insert(link);
  }
  Result<SessionInfo> find(std::string_view id) override {
    const std::lock_guard lock(mutex_);
    const auto found = sessions_.find(std::string(id));
    if (found == sessions_.end()) return fail(ErrorCode::kNotFound, "gone");
    return found->second;
  }
  Result<std::vector<WorkerInfo>> alive() override {
    const std::lock_guard lock(mutex_);
    if (away_) return fail(ErrorCode::kUnavailable, "away");
    if (!alive_) return std::vector<WorkerInfo>{};
    return alive_workers;
  }
  Result<bool> lost(std::string_view worker, std::string_view incarnation) override {
    const std::lock_guard lock(mutex_);
    lost_.push_back(std::string(worker) + "|" + std::string(incarnation));
    return true;
  }
  Result<void> refused(std::string_view session, std::string_view worker,
                       std::uint64_t placement) override {
    const std::lock_guard lock(mutex_);
    if (away_) return fail(ErrorCode::kUnavailable, "away");
    const bool known = sessions_.contains(std::string(session));
    refused_.push_back((known ? "known|" : "?|") + std::string(worker) + "|" +
                       std::to_string(placement));
    return {};
  }
  std::vector<std::string> refused_sessions() {
    const std::lock_guard lock(mutex_);
    return refused_;
  }
  Result<Placed> place(const PlaceRequest&) override { return fail(ErrorCode::kInternal, ""); }
  Result<std::vector<SessionInfo>> sessions_of(std::string_view) override {
    return fail(ErrorCode::kInternal, "");
  }
  Result<std::vector<SessionInfo>> sessions_on(std::string_view) override {
    return fail(ErrorCode::kInternal, "");
  }
  Result<void> end(std::string_view) override { return {}; }
  Result<void> end_all_of(std::string_view) override { return {}; }
  Result<void> end_all_by(std::string_view) override { return {}; }
  Result<void> end_all_from(std::string_view, std::string_view) override { return {}; }
  bool reachable() override { return true; }

  std::vector<WorkerInfo> alive_workers{{"worker", "", "one", 4, 0, false, {}}};

 private:
  std::mutex mutex_;
  std::map<std::string, Attachment> tickets_;
  std::map<std::string, SessionInfo> sessions_;
  std::vector<std::string> lost_;
  std::vector<std::string> refused_;
  std::set<std::string> ended_;
  std::atomic<bool> away_ = false, alive_ = true;
};

/// A render worker on a real port with the Attach behaviour that a test defines.
class FakeWorker final : public diaphane::v1::RenderWorker::Service {
 public:
  using Stream = grpc::ServerReaderWriter<diaphane::v1::AttachReply, diaphane::v1::AttachRequest>;
  using Behaviour = std::function<grpc::Status(grpc::ServerContext&, Stream&)>;

  explicit FakeWorker(Behaviour behaviour = echo()) : behaviour_(std::move(behaviour)) {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
  }
  ~FakeWorker() override { die(); }

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  /// Breaks all connections and closes the port, like a killed process.
  void die() {
    if (server_) server_->Shutdown(std::chrono::system_clock::now());
  }

  static Behaviour echo() {
    return [](grpc::ServerContext&, Stream& stream) {
      diaphane::v1::AttachRequest request;
      while (stream.Read(&request)) {
        diaphane::v1::AttachReply reply;
        reply.set_server_message(request.client_message());
        if (!stream.Write(reply)) break;
      }
      return grpc::Status::OK;
    };
  }
  static Behaviour ending(grpc::StatusCode code) {
    return [code](grpc::ServerContext&, Stream&) { return grpc::Status(code, "as wanted"); };
  }
  static Behaviour without_memory() {
    return [](grpc::ServerContext&, Stream&) {
      diaphane::v1::Refusal why;
      why.set_no_memory(true);
      return grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "full", why.SerializeAsString());
    };
  }
  static Behaviour displacing() {
    return [](grpc::ServerContext&, Stream&) {
      diaphane::v1::Refusal why;
      why.set_displaced(true);
      return grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "", why.SerializeAsString());
    };
  }
  /// Sends messages of `bytes` until the call ends.
  static Behaviour flood(std::size_t bytes) {
    return [bytes](grpc::ServerContext& context, Stream& stream) {
      diaphane::v1::AttachReply reply;
      reply.set_server_message(std::string(bytes, 'x'));
      while (!context.IsCancelled() && stream.Write(reply)) {
      }
      return grpc::Status::OK;
    };
  }

  /// Returns the received messages in order, once there are `count` or after a minute.
  std::vector<std::string> received(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::seconds(60), [&] { return received_.size() >= count; });
    return received_;
  }
  bool calls_ended(int count) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(60), [&] { return ended_ >= count; });
  }
  void note(const std::string& message) {
    const std::lock_guard lock(mutex_);
    received_.push_back(message);
    changed_.notify_all();
  }
  diaphane::v1::Open last_open() {
    const std::lock_guard lock(mutex_);
    return open_;
  }

  grpc::Status Attach(grpc::ServerContext* context, Stream* stream) override {
    diaphane::v1::AttachRequest first;
    if (stream->Read(&first)) {
      const std::lock_guard lock(mutex_);
      open_ = first.open();
    }
    const grpc::Status status = behaviour_(*context, *stream);
    const std::lock_guard lock(mutex_);
    ++ended_;
    changed_.notify_all();
    return status;
  }
  grpc::Status RenderStill(grpc::ServerContext*, const diaphane::v1::StillRequest* request,
                           diaphane::v1::StillReply* reply) override {
    if (request->preset() == "missing") return {grpc::StatusCode::NOT_FOUND, ""};
    reply->set_jpeg("jpeg of " + request->volume_id() + " " + request->preset());
    return grpc::Status::OK;
  }
  grpc::Status GetErrorCurve(grpc::ServerContext*, const diaphane::v1::ErrorCurveRequest* request,
                             diaphane::v1::ErrorCurve* reply) override {
    if (request->session_id() == "missing") return {grpc::StatusCode::NOT_FOUND, ""};
    if (request->session_id() == "refused") return {grpc::StatusCode::PERMISSION_DENIED, ""};
    reply->set_epoch(7);
    diaphane::v1::ErrorCurve::Point& point = *reply->add_points();
    point.set_samples(16);
    point.set_seconds(0.5);
    point.set_error(0.25);
    return grpc::Status::OK;
  }

 private:
  Behaviour behaviour_;
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::string> received_;
  diaphane::v1::Open open_;
  int ended_ = 0;
};

}  // namespace diaphane::api::stream
