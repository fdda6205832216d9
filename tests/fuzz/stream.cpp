// Any bytes as messages of three people to one session: one byte chooses the person or action, two
// give the length, and the message follows. Messages are parsed as gateway and renderd parse them,
// and accepted ones are executed, including live links and followers' free cameras.
#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <array>

#include "api/proto/stream.pb.h"
#include "api/proto/worker.pb.h"
#include "renderd/scene/presets.h"
#include "renderd/session/state.h"
#include "tests/fuzz/must.h"
#include "tests/support/renderd/test_messages.h"

using namespace diaphane;
using namespace diaphane::render;

namespace {

constexpr std::array<std::string_view, 3> kPeople{"owner", "0190b2a0-0000-7000-8000-000000000001",
                                                  "0190b2a0-0000-7000-8000-000000000002"};

/// Parses like gRPC and the sessions. A parsed message can be serialised and parsed again.
template <typename T>
bool read(const std::string& bytes) {
  T message;
  if (!message.ParseFromString(bytes)) return false;
  T again;
  MUST(again.ParseFromString(message.SerializeAsString()));
  MUST(again.ByteSizeLong() == message.ByteSizeLong());
  return true;
}

/// Any message that is nested more than 100 levels deep is refused.
void read_all(const std::string& bytes) {
  (void)read<v1::ClientMessage>(bytes);
  (void)read<v1::ServerMessage>(bytes);
  (void)read<v1::AttachRequest>(bytes);
  (void)read<v1::AttachReply>(bytes);
  (void)read<v1::Refusal>(bytes);
  (void)read<v1::StillRequest>(bytes);
  (void)read<v1::StillReply>(bytes);
  (void)read<v1::AssistRequest>(bytes);
  (void)read<v1::AssistReply>(bytes);
  v1::Scene scene;
  if (scene.ParseFromString(bytes)) (void)check_scene(scene);
}

class Meeting {
 public:
  Meeting() {
    group_.requested.scene = std::make_shared<const v1::Scene>(plain_scene());
    own_.requested.scene = group_.requested.scene;
    own_.camera_only = true;
    for (std::size_t i = 0; i < kPeople.size(); ++i) come(i);
    const auto alone = attach(own_, owner(), now_);
    MUST(alone.has_value());
    own_connection_ = alone->connection;
    (void)receive(own_, own_connection_, hello(), now_);
  }

  void step(unsigned what, const std::string& bytes) {
    now_ += std::chrono::milliseconds(60);
    const std::size_t who = what % 4;
    if (who == 3) return read_all(bytes);
    switch (what / 4 % 4) {
      case 1:
        return come(who);
      case 2:
        detach(group_, connections_[who], now_);
        now_ += std::chrono::seconds(6);
        return;
      case 3:
        return hear(own_, own_connection_, bytes);
      default:
        return hear(group_, connections_[who], bytes);
    }
  }

 private:
  void come(std::size_t who) {
    JoinRequest join = who == 0 ? owner() : JoinRequest{};
    join.participant = kPeople[who];
    const auto attached = attach(group_, join, now_);
    MUST(attached.has_value());
    connections_[who] = attached->connection;
    (void)receive(group_, connections_[who], hello(), now_);
  }

  void hear(SessionState& state, std::uint64_t connection, const std::string& bytes) {
    v1::ClientMessage message;
    if (!message.ParseFromString(bytes) || !state.audience.find(connection)) return;
    if (const auto refused = refused_request(state, connection, message)) {
      MUST(!refused->message().empty());
      return;
    }
    const Outcome outcome = receive(state, connection, message, now_);
    if (outcome.problem) MUST(!outcome.problem->message().empty());
    if (outcome.free_camera) {
      Receiver* const receiver = state.audience.find(connection);
      MUST(!(*outcome.free_camera && state.audience.presents(*receiver)));
      use_free_camera(state, *receiver, *outcome.free_camera, now_);
    }
    MUST(state.requested.scene && check_scene(*state.requested.scene));
    MUST(state.audience.receivers.size() <= kPeople.size());
    if (&state == &group_) {
      follow(own_, *group_.requested.scene, now_);
      MUST(check_scene(*own_.requested.scene).has_value());
    }
    if (outcome.wake) began(state, ++epoch_, state.requested);
    (void)watched(state, now_);
    (void)overdue_greetings(state, now_);
  }

  SessionState group_, own_;
  std::array<std::uint64_t, kPeople.size()> connections_{};
  std::uint64_t own_connection_ = 0, epoch_ = 0;
  TimePoint now_{std::chrono::seconds(1)};
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  static auto* const silenced = google::protobuf::SetLogHandler(nullptr);
  (void)silenced;
  Meeting meeting;
  while (size >= 3) {
    const std::size_t length = std::min<std::size_t>(data[1] + 256 * data[2], size - 3);
    meeting.step(data[0], {reinterpret_cast<const char*>(data) + 3, length});
    data += 3 + length;
    size -= 3 + length;
  }
  return 0;
}
