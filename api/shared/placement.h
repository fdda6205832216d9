#pragma once

#include "api/shared/stills.h"
#include "directory/placement.h"

/// Imports the names of the session directory that the API's services use.
namespace diaphane::api {

using directory::Attachment;
using directory::LinkStore;
using directory::Placed;
using directory::Placement;
using directory::PlaceRequest;
using directory::session_viewer_of;
using directory::SessionInfo;
using directory::SessionViewer;
using directory::Tickets;
using directory::to_string;

}  // namespace diaphane::api
