#include "renderd/serve/grpc_assistants.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <set>
#include <tuple>
#include <utility>

#include "api/proto/worker.grpc.pb.h"
#include "common/log.h"
#include "common/wire/grpc_credentials.h"
#include "renderd/composite/wire.h"

namespace diaphane::render {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kRetry{1};
/// How long a scan must have shown the same phase before another worker loads that phase. While
/// phases are played, the worker that shows them renders alone.
constexpr std::chrono::milliseconds kSettled{300};
/// A band has about 1 MB of pixels, and up to one more row of the widest canvas.
constexpr int kMostMessageBytes = 8 << 20;

v1::AssistRequest request_of(const AssistTask& task) {
  v1::AssistRequest request;
  v1::AssistTask& message = *request.mutable_task();
  message.set_epoch(task.epoch);
  *message.mutable_scene() = *task.scene;
  message.set_width(task.canvas.width);
  message.set_height(task.canvas.height);
  message.set_picture_row(task.canvas.first_row);
  message.set_picture_height(task.canvas.whole_height);
  message.set_first_row(task.share.first_row);
  message.set_last_row(task.share.last_row);
  message.set_part(task.share.part);
  message.set_parts(task.share.parts);
  message.set_sequence(task.share.sequence);
  message.set_guided(task.guided);
  return request;
}

/// Converts a received band. Returns nullopt if it is invalid.
std::optional<AssistPart> part_of(const v1::AssistBand& band) {
  if (band.width() == 0 || band.width() > kLongestCanvas || band.rows() > kLongestCanvas) {
    return std::nullopt;
  }
  auto pixels =
      pixels_from_wire(band.pixels(), std::size_t{band.width()} * std::size_t{band.rows()});
  if (!pixels) return std::nullopt;
  auto guides = guides_from_wire(band.guides(), pixels->size());
  if (!guides) return std::nullopt;
  AssistPart part;
  part.epoch = band.epoch();
  part.sequence = band.sequence();
  part.film = {band.width(),   band.first_row(),   band.rows(),
               band.samples(), *std::move(pixels), *std::move(guides)};
  part.seconds = static_cast<double>(band.render_us()) * 1e-6;
  part.bytes = band.pixels().size() + band.guides().size();
  return part;
}

/// The received bands and the state of one connection. Used by the compositor's thread and by
/// gRPC's threads.
class Exchange {
 public:
  void put(AssistPart part, bool last) {
    const std::lock_guard lock(mutex_);
    parts_.emplace_back(std::move(part), last);
  }
  /// Returns the oldest band and whether it was the last of its part, or nullopt.
  std::optional<std::pair<AssistPart, bool>> take() {
    const std::lock_guard lock(mutex_);
    if (parts_.empty()) return std::nullopt;
    auto first = std::move(parts_.front());
    parts_.pop_front();
    return first;
  }
  std::atomic<bool> ready{false};
  std::atomic<bool> broken{false};

 private:
  std::mutex mutex_;
  std::deque<std::pair<AssistPart, bool>> parts_;
};

}  // namespace

/// A worker and its calls in progress.
struct AssistPeer {
  std::string address;
  bool spare = false;  ///< Loan::spare
  std::unique_ptr<v1::RenderWorker::Stub> stub;
  /// Whether a call ended before the worker was ready, for another reason than too many sessions.
  std::atomic<bool> refuses{false};

  void began(grpc::ClientContext* call) {
    const std::lock_guard lock(mutex_);
    ++calls_;
    contexts_.insert(call);
    if (left_) call->TryCancel();
  }
  /// To be called before the context is destroyed.
  void forget(grpc::ClientContext* call) {
    const std::lock_guard lock(mutex_);
    contexts_.erase(call);
  }
  void ended() {
    // Notifies under the lock, because the waiting thread may destroy this object right afterwards.
    const std::lock_guard lock(mutex_);
    --calls_;
    changed_.notify_all();
  }
  /// Returns whether there are other calls than the one that is ending.
  bool has_others() {
    const std::lock_guard lock(mutex_);
    return calls_ > 1;
  }
  /// Cancels all calls, including those that begin later.
  void leave() {
    const std::lock_guard lock(mutex_);
    left_ = true;
    for (grpc::ClientContext* call : contexts_) call->TryCancel();
  }
  /// Returns whether all calls have ended after leave().
  bool gone() {
    const std::lock_guard lock(mutex_);
    return left_ && calls_ == 0;
  }
  void await_idle() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return calls_ == 0; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::set<grpc::ClientContext*> contexts_;
  int calls_ = 0;
  bool left_ = false;
};

/// The worker that a session's assistant represents, which may change.
struct AssistSlot {
  bool always = false;  ///< whether the worker stays the same and is retried after failures

  std::shared_ptr<AssistPeer> peer() const {
    const std::lock_guard lock(mutex_);
    return peer_;
  }
  void put(std::shared_ptr<AssistPeer> peer) {
    const std::lock_guard lock(mutex_);
    peer_ = std::move(peer);
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<AssistPeer> peer_;
};

namespace {

/// One Assist call on the calling side. Deletes itself when gRPC is done with it, which is never
/// before leave() was called.
class CallReactor final : public grpc::ClientBidiReactor<v1::AssistRequest, v1::AssistReply> {
 public:
  CallReactor(std::shared_ptr<AssistPeer> peer, const AssistOrder& order,
              std::shared_ptr<Exchange> exchange)
      : peer_(std::move(peer)), exchange_(std::move(exchange)) {
    peer_->stub->async()->Assist(&context_, this);
    // Keeps the call open while requests may be written from outside gRPC's callbacks.
    AddHold();
    v1::AssistRequest open;
    open.mutable_open()->set_volume_id(order.volume_id);
    open.mutable_open()->set_with_table(order.with_table);
    open.mutable_open()->set_volume_phase(order.phase);
    open.mutable_open()->set_seed(order.seed);
    open.mutable_open()->set_first_sample(order.first_sample);
    open.mutable_open()->set_spare(peer_->spare);
    send(std::move(open));
    StartRead(&reply_);
    StartCall();
    peer_->began(&context_);
  }

  /// Sends a request. A task replaces one that was not sent yet.
  void send(v1::AssistRequest request) {
    const std::lock_guard lock(mutex_);
    if (closing_) return;
    if (request.has_task()) {
      std::erase_if(queue_, [](const v1::AssistRequest& waits) { return waits.has_task(); });
    }
    queue_.push_back(std::move(request));
    write_next();
  }
  /// Ends the call. Nothing may be sent afterwards.
  void leave() {
    {
      const std::lock_guard lock(mutex_);
      closing_ = true;
      queue_.clear();
    }
    context_.TryCancel();
    RemoveHold();
  }

  void OnReadDone(bool ok) override {
    if (!ok) {
      exchange_->broken = true;
      return;
    }
    if (reply_.has_ready()) exchange_->ready = was_ready_ = true;
    if (reply_.has_band()) {
      auto part = part_of(reply_.band());
      if (!part) {
        exchange_->broken = true;
        context_.TryCancel();
      } else {
        exchange_->put(std::move(*part), reply_.band().last());
      }
    }
    StartRead(&reply_);
  }
  void OnWriteDone(bool ok) override {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    if (!ok) {
      queue_.clear();
      exchange_->broken = true;
      return;
    }
    write_next();
  }
  void OnDone(const grpc::Status& status) override {
    // A worker without room for another picture may still help with other pictures of this worker.
    const bool full = status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED;
    if (!was_ready_ && status.error_code() != grpc::StatusCode::CANCELLED &&
        !(full && peer_->has_others())) {
      const bool refused_before = peer_->refuses.exchange(true);
      if (!refused_before && status.error_code() == grpc::StatusCode::PERMISSION_DENIED) {
        log::error("assist_refused",
                   {{"address", peer_->address}, {"message", status.error_message()}});
      }
    }
    exchange_->broken = true;
    const auto peer = std::move(peer_);
    peer->forget(&context_);
    delete this;
    peer->ended();
  }

 private:
  void write_next() {
    if (writing_ || queue_.empty()) return;
    writing_ = true;
    request_ = std::move(queue_.front());
    queue_.pop_front();
    StartWrite(&request_);
  }

  grpc::ClientContext context_;
  std::shared_ptr<AssistPeer> peer_;
  std::shared_ptr<Exchange> exchange_;
  bool was_ready_ = false;  ///< used only in callbacks, which are sequential
  v1::AssistReply reply_;
  std::mutex mutex_;
  std::deque<v1::AssistRequest> queue_;
  v1::AssistRequest request_;
  bool writing_ = false, closing_ = false;
};

/// An assistant for one session on one worker. All calls come from the session's renderer.
class GrpcAssistant final : public Assistant {
 public:
  GrpcAssistant(std::shared_ptr<const AssistSlot> slot, AssistOrder order,
                std::shared_ptr<std::atomic<double>> helped_seconds)
      : slot_(std::move(slot)),
        order_(std::move(order)),
        helped_seconds_(std::move(helped_seconds)),
        peer_(slot_->peer()) {
    connect();
  }
  ~GrpcAssistant() override { disconnect(); }

  void expect(const v1::Scene& scene) override {
    const VolumeCopy copy{scene.show_table(), scene.volume_phase()};
    const VolumeCopy before = std::exchange(expected_, copy).value_or(copy);
    if (before == copy) return;
    std::tie(order_.with_table, order_.phase) = copy;
    disconnect();
    exchange_ = std::make_shared<Exchange>();
    connect_after_ = Clock::now() + kSettled;
  }

  void begin(const AssistTask& task) override {
    // Parts in transit are of older tasks but valid. Their epoch decides whether they are merged or
    // dropped.
    if (call_ != nullptr) call_->send(request_of(task));
  }

  std::optional<AssistPart> take(const AssistNews& news) override {
    auto next = exchange_->take();
    if (!next) return std::nullopt;
    measure(next->first.bytes);
    *helped_seconds_ += std::max(next->first.seconds, 0.0);
    if (next->second && call_ != nullptr) {
      v1::AssistRequest request;
      request.mutable_taken()->set_samples(news.samples);
      const bool known = news.error > 0 && news.error < 1e6;
      request.mutable_taken()->set_error(known ? news.error : 0);
      call_->send(std::move(request));
    }
    return std::move(next->first);
  }

  bool lost() override {
    if (auto peer = slot_->peer(); peer != peer_) {
      disconnect();
      peer_ = std::move(peer);
      connect();
      return true;
    }
    if (!peer_) return true;
    if (call_ == nullptr) {
      if (Clock::now() >= connect_after_) connect();
      return true;
    }
    if (!exchange_->broken) return !exchange_->ready;
    if (exchange_->ready.exchange(false)) {
      log::warning("assistant_lost", {{"address", peer_->address}});
    }
    if (!slot_->always && peer_->refuses) return true;
    if (Clock::now() - tried_ > kRetry) {
      disconnect();
      connect();
    }
    return true;
  }

  bool may_pause() const override { return peer_ && peer_->spare; }
  double bytes_per_second() const override { return bytes_per_second_; }

 private:
  using VolumeCopy = std::pair<bool, std::uint32_t>;  ///< with its table, phase

  void connect() {
    tried_ = Clock::now();
    exchange_ = std::make_shared<Exchange>();
    if (peer_) call_ = new CallReactor(peer_, order_, exchange_);
  }
  void disconnect() {
    if (auto* call = std::exchange(call_, nullptr)) call->leave();
  }
  /// Estimates the bandwidth from bands that arrive one after the other.
  void measure(std::uint64_t bytes) {
    const auto now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - measured_since_).count();
    if (seconds > 1) {
      measured_since_ = now;
      measured_ = 0;
    }
    measured_ += bytes;
    // A lower bound, because the peer sends only what was requested.
    if (seconds > 0.05 && seconds <= 1) {
      bytes_per_second_ =
          std::max(0.9 * bytes_per_second_, static_cast<double>(measured_) / seconds);
    }
  }

  const std::shared_ptr<const AssistSlot> slot_;
  AssistOrder order_;
  std::optional<VolumeCopy> expected_;  ///< of the newest scene; nullopt: that of `order_`
  const std::shared_ptr<std::atomic<double>> helped_seconds_;
  std::shared_ptr<AssistPeer> peer_;  ///< null: represents no worker
  std::shared_ptr<Exchange> exchange_;
  CallReactor* call_ = nullptr;
  Clock::time_point tried_{};
  Clock::time_point connect_after_{};
  Clock::time_point measured_since_{};
  std::uint64_t measured_ = 0;
  double bytes_per_second_ = 1e8;
};

}  // namespace

GrpcAssistants::GrpcAssistants(std::vector<std::string> addresses, const wire::InnerTls& tls,
                               std::size_t most)
    : tls_(tls), credentials_(wire::channel_credentials(tls)) {
  for (const std::string& address : addresses) {
    peers_.push_back(open({address}));
    fixed_.push_back(std::make_shared<AssistSlot>());
    fixed_.back()->always = true;
    fixed_.back()->put(peers_.back());
  }
  for (std::size_t i = 0; i < most; ++i) coming_.push_back(std::make_shared<AssistSlot>());
}

GrpcAssistants::~GrpcAssistants() {
  for (const auto& peer : peers_) peer->await_idle();
}

std::shared_ptr<AssistPeer> GrpcAssistants::open(const Loan& loan) const {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMostMessageBytes);
  // Detects within 15 s that a worker vanished without closing the connection, and then tries to
  // reconnect every second.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 10'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5'000);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 1'000);
  auto peer = std::make_shared<AssistPeer>();
  peer->stub =
      v1::RenderWorker::NewStub(wire::open_channel(loan.address, tls_, credentials_, arguments));
  peer->address = loan.address;
  peer->spare = loan.spare;
  return peer;
}

std::vector<std::unique_ptr<Assistant>> GrpcAssistants::assistants(const AssistOrder& order) {
  std::vector<std::unique_ptr<Assistant>> all;
  for (const auto* slots : {&fixed_, &coming_}) {
    for (const auto& slot : *slots) {
      all.push_back(std::make_unique<GrpcAssistant>(slot, order, helped_seconds_));
    }
  }
  return all;
}

void GrpcAssistants::borrow(const std::vector<Loan>& loans) {
  const std::lock_guard lock(mutex_);
  const auto is_for = [](const AssistPeer& peer, const Loan& loan) {
    return peer.address == loan.address && peer.spare == loan.spare;
  };
  for (const auto& slot : coming_) {
    const auto peer = slot->peer();
    const auto requested = [&](const Loan& loan) { return is_for(*peer, loan); };
    if (!peer || std::any_of(loans.begin(), loans.end(), requested)) continue;
    slot->put(nullptr);
    peer->leave();
  }
  for (const Loan& loan : loans) {
    const auto has = [&](const auto& slot) {
      const auto peer = slot->peer();
      return peer && is_for(*peer, loan);
    };
    if (std::any_of(coming_.begin(), coming_.end(), has)) continue;
    const auto free = std::find_if(coming_.begin(), coming_.end(),
                                   [](const auto& slot) { return !slot->peer(); });
    if (free == coming_.end()) break;
    peers_.push_back(open(loan));
    (*free)->put(peers_.back());
  }
  std::erase_if(peers_, [&](const auto& peer) { return peer->gone(); });
}

std::vector<std::string> GrpcAssistants::borrowed() const {
  std::vector<std::string> all;
  for (const auto& slot : coming_) {
    if (const auto peer = slot->peer()) all.push_back(peer->address);
  }
  return all;
}

std::vector<std::string> GrpcAssistants::refusing() const {
  std::vector<std::string> all;
  for (const auto& slot : coming_) {
    if (const auto peer = slot->peer(); peer && peer->refuses) all.push_back(peer->address);
  }
  return all;
}

}  // namespace diaphane::render
