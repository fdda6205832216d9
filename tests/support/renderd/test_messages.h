#pragma once

#include <memory>

#include "renderd/session/pictures.h"

/// Messages for tests of a session.
namespace diaphane::render {

inline v1::Scene plain_scene() {
  v1::Scene scene;
  v1::Channel& channel = *scene.mutable_transfer_function()->add_channels();
  channel.set_name("bone");
  for (const double value : {100.0, 1000.0}) {
    v1::OpacityPoint& point = *channel.add_opacity();
    point.set_value(value);
    point.set_opacity(value / 1000);
  }
  channel.mutable_diffuse()->set_r(0.8);
  channel.mutable_diffuse()->set_g(0.8);
  channel.mutable_diffuse()->set_b(0.8);
  scene.mutable_transfer_function()->set_extinction_per_mm(1);
  v1::Rgb& sky = *scene.add_lights()->mutable_environment()->mutable_radiance();
  sky.set_r(1);
  sky.set_g(1);
  sky.set_b(1);
  scene.mutable_camera()->mutable_eye()->set_y(-500);
  scene.mutable_camera()->mutable_target();
  scene.mutable_camera()->mutable_up()->set_z(1);
  scene.mutable_camera()->set_vertical_fov_degrees(40);
  scene.mutable_phase();
  scene.mutable_display()->mutable_background();
  return scene;
}

/// The owner of a scan in their own session.
inline JoinRequest owner() {
  JoinRequest join;
  join.viewer = ViewerKind::kOwner;
  return join;
}

inline v1::ClientMessage hello(std::uint32_t width = 640, std::uint32_t height = 480) {
  v1::ClientMessage message;
  v1::Hello& body = *message.mutable_hello();
  body.set_protocol(1);
  body.add_codecs(v1::JPEG);
  body.mutable_viewport()->set_width(width);
  body.mutable_viewport()->set_height(height);
  return message;
}

inline v1::ClientMessage update(std::uint64_t seq, const v1::Scene& scene) {
  v1::ClientMessage message;
  message.mutable_scene()->set_input_seq(seq);
  *message.mutable_scene()->mutable_scene() = scene;
  return message;
}

inline v1::ClientMessage turned(std::uint64_t seq) {
  v1::Scene scene = plain_scene();
  scene.mutable_camera()->mutable_eye()->set_x(static_cast<double>(seq));
  return update(seq, scene);
}

inline v1::ClientMessage ack(std::uint64_t seq) {
  v1::ClientMessage message;
  message.mutable_ack()->set_seq(seq);
  return message;
}

inline FrameInfo frame(std::uint64_t epoch, bool first = true, std::uint64_t input_seq = 0) {
  FrameInfo info;
  info.epoch = epoch;
  info.first_of_epoch = first;
  info.input_seq = input_seq;
  // Ensures that no two pictures are equal.
  static std::uint64_t samples = 1;
  info.samples = first ? 1 : ++samples;
  return info;
}

}  // namespace diaphane::render
