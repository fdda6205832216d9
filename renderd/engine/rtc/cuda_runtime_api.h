#pragma once
// Built into NVRTC.
