#pragma once

#include <optional>
#include <string>

namespace diaphane::render {

enum class H264Device {
  kX264,   ///< the encoder x264 on the CPU
  kNvenc,  ///< the encoder of an NVIDIA GPU, which data-centre GPUs (H100, H200) lack
};

/// The encoders that this process can use.
struct H264Probe {
  bool x264 = false;          ///< whether FFmpeg includes it
  bool nvenc = false;         ///< whether a session encoded a frame
  std::string nvenc_why_not;  ///< reason, empty if it works
};

/// Returns NVENC if it works, else x264 if available, else nullopt. Pure.
std::optional<H264Device> choose_h264(const H264Probe& probe);

/// Tests each encoder with a real frame, once per process, and logs the result.
const H264Probe& h264_probe();

}  // namespace diaphane::render
