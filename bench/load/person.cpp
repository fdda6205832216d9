#include "bench/load/person.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/schedule/trace.h"

namespace diaphane::api::load {
namespace {

using Clock = std::chrono::steady_clock;

// Degrees per input of a drag. A full back-and-forth movement takes twelve seconds, so that the
// visible sides and the lighting vary.
constexpr double kDegreesAnInput = 0.5;
constexpr auto kInputInterval = std::chrono::duration_cast<Clock::duration>(
    std::chrono::duration<double>(render::bench::kInputInterval));

double seconds_between(TimePoint from, TimePoint to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

v1::Scene turned(const v1::Scene& scene, double degrees) {
  v1::Scene moved = scene;
  const v1::Vec3& target = scene.camera().target();
  const v1::Vec3& up = scene.camera().up();
  const double length = std::sqrt(up.x() * up.x() + up.y() * up.y() + up.z() * up.z());
  if (length == 0) return moved;
  const double k[3] = {up.x() / length, up.y() / length, up.z() / length};
  const double v[3] = {scene.camera().eye().x() - target.x(), scene.camera().eye().y() - target.y(),
                       scene.camera().eye().z() - target.z()};
  const double angle = degrees * std::numbers::pi / 180;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const double along = (k[0] * v[0] + k[1] * v[1] + k[2] * v[2]) * (1 - c);
  v1::Vec3& eye = *moved.mutable_camera()->mutable_eye();  // Rodrigues' rotation formula
  eye.set_x(target.x() + v[0] * c + (k[1] * v[2] - k[2] * v[1]) * s + k[0] * along);
  eye.set_y(target.y() + v[1] * c + (k[2] * v[0] - k[0] * v[2]) * s + k[1] * along);
  eye.set_z(target.z() + v[2] * c + (k[0] * v[1] - k[1] * v[0]) * s + k[2] * along);
  return moved;
}

Person::Person(boost::asio::io_context& io, ViewerOptions options, std::string preset)
    : io_(io), options_(std::move(options)), preset_(std::move(preset)) {}

void Person::enter(const std::string& ticket, std::function<void(bool)> ready) {
  viewer_ = std::make_unique<Viewer>(io_, options_, weak_from_this());
  viewer_->post([self = shared_from_this(), ready = std::move(ready)]() mutable {
    self->ready_ = std::move(ready);
    self->entered_ = Clock::now();
  });
  viewer_->enter(ticket);
}

void Person::measure(TimePoint from, TimePoint until) {
  viewer_->post([self = shared_from_this(), from, until] {
    self->from_ = from;
    self->until_ = until;
  });
}

void Person::leave() {
  viewer_->post([self = shared_from_this()] { self->leaving_ = true; });
  viewer_->leave();
}

void Person::cut() {
  viewer_->post([self = shared_from_this()] { self->leaving_ = true; });
  viewer_->cut();
}

void Person::show(bool visible) {
  v1::ClientMessage message;
  message.mutable_visibility()->set_visible(visible);
  viewer_->send(message);
}

void Person::resize(std::uint32_t width, std::uint32_t height) {
  viewer_->post([self = shared_from_this(), width, height] {
    v1::ClientMessage message;
    message.mutable_scene()->set_input_seq(++self->input_seq_);
    message.mutable_scene()->mutable_viewport()->set_width(width);
    message.mutable_scene()->mutable_viewport()->set_height(height);
    self->viewer_->send(message);
  });
}

void Person::after(double seconds, std::function<void()> done) {
  viewer_->after(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(seconds)),
      std::move(done));
}

void Person::on_config(const v1::Config& config) {
  scene_ = config.scene();
  input_seq_ = config.input_seq();
  const auto chosen = std::find_if(config.presets().begin(), config.presets().end(),
                                   [&](const v1::Preset& p) { return p.name() == preset_; });
  if (chosen == config.presets().end()) return;
  scene_ = chosen->scene();
  v1::ClientMessage message;
  message.mutable_scene()->set_input_seq(++input_seq_);
  *message.mutable_scene()->mutable_scene() = scene_;
  viewer_->send(message);
}

void Person::on_frame(const ReceivedFrame& frame) {
  ++frames_;
  if (!opening_) opening_ = seconds_between(entered_, frame.at);
  if (ready_ && frame.input_seq >= input_seq_) std::exchange(ready_, nullptr)(true);
  const OpenInputs::Shown shown = open_.shown(frame.input_seq, frame.at, from_);
  measurements_.input_to_frame.insert(measurements_.input_to_frame.end(), shown.seconds.begin(),
                                      shown.seconds.end());
  if (!shown.seconds.empty()) {
    measurements_.answer_seconds.push_back(shown.seconds.front());
    measurements_.render_seconds.push_back(frame.render_seconds);
    measurements_.encode_seconds.push_back(frame.encode_seconds);
  }
  if (!measured(frame.at)) return;
  ++measurements_.frames;
  measurements_.bytes += frame.bytes;
  if (!moving_) return;
  ++measurements_.moving_frames;
  measurements_.moving_bytes += frame.bytes;
  measurements_.pixels += double(frame.width) * frame.height;
}

void Person::on_message(const v1::ServerMessage& message) {
  if (message.has_problem()) ++problems_;
}

void Person::on_closed(int code) {
  code_ = leaving_ ? -1 : code;
  if (moving_) end_drag(Clock::now());
  if (ready_) std::exchange(ready_, nullptr)(false);
}

void Person::drag(double seconds, std::function<void()> done) {
  viewer_->post([self = shared_from_this(), seconds, done = std::move(done)]() mutable {
    const TimePoint now = Clock::now();
    self->done_ = std::move(done);
    self->moving_ = true;
    self->drag_began_ = self->next_input_ = now;
    self->drag_ends_ =
        now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
    self->input();
  });
}

void Person::play(std::shared_ptr<const Recording> recording, std::size_t first) {
  recorded_ = first % recording->size();
  recording_ = std::move(recording);
}

v1::Scene Person::next_scene() {
  if (recording_) return recording_->scene(recorded_);
  degrees_ += kDegreesAnInput;
  return turned(scene_, degrees_);
}

// Skips missed inputs: a delayed page sends its next input with its next displayed frame.
std::optional<TimePoint> Person::time_after(TimePoint now) {
  if (!recording_) {
    while (next_input_ <= now) next_input_ += kInputInterval;
    return next_input_;
  }
  while (next_input_ <= now) {
    const double gap = recording_->gap_after(recorded_);
    recorded_ = (recorded_ + 1) % recording_->size();
    if (gap == 0) return std::nullopt;
    next_input_ += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(gap));
  }
  return next_input_;
}

void Person::input() {
  if (!moving_) return;
  const TimePoint now = Clock::now();
  v1::ClientMessage message;
  message.mutable_scene()->set_input_seq(++input_seq_);
  *message.mutable_scene()->mutable_scene() = next_scene();
  if (now < until_) {
    open_.sent(input_seq_, now);
    measurements_.inputs += measured(now);
  }
  viewer_->send(message);
  const auto next = time_after(now);
  if (!next || now >= drag_ends_) return end_drag(now);
  viewer_->after(*next - now, [self = shared_from_this()] { self->input(); });
}

void Person::end_drag(TimePoint now) {
  moving_ = false;
  const TimePoint begin = std::max(drag_began_, from_);
  const TimePoint end = std::min(now, until_);
  if (end > begin) measurements_.moving_seconds += seconds_between(begin, end);
  if (done_) std::exchange(done_, nullptr)();
}

void Person::give_up(TimePoint now) {
  if (moving_) end_drag(now);
  const OpenInputs::Shown left = open_.give_up(now, from_);
  measurements_.input_to_frame.insert(measurements_.input_to_frame.end(), left.seconds.begin(),
                                      left.seconds.end());
}

}  // namespace diaphane::api::load
