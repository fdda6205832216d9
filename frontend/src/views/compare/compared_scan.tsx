import type { RefObject } from "preact";
import type { DataSet } from "../../api/types";
import { roleOf } from "../../live/role";
import { isOver } from "../../protocol/connection";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Link } from "../router";
import { KindChip, titleOf } from "../scan_card";
import { OrientationCube } from "../viewer/orientation_cube";
import { PhaseLine } from "../viewer/phase_line";
import { Presets } from "../viewer/presets";
import { StatusLine } from "../viewer/status_line";
import { pictureData } from "../viewer/viewer_stage";

export interface ComparedScanProps {
  readonly canvas: RefObject<HTMLCanvasElement | null>;
  readonly session: ViewerSession | null;
  readonly fault: string;
  readonly set: DataSet | null;
  readonly side: number;
}

/** One of two scans that are shown side by side: its picture, its name and its looks. */
export function ComparedScan({ canvas, session, fault, set, side }: ComparedScanProps) {
  const shown = session !== null && !isOver(session.connection.value) ? session : null;
  const title = set ? titleOf(set) : "";
  const role = roleOf(session?.audience.value ?? null);
  return (
    <div role="group" class="compare-pane" data-side={side} aria-label={title}>
      <div class="compare-picture">
        <canvas
          ref={canvas}
          tabIndex={0}
          role="application"
          aria-label={`${title}. ${t.viewer.stage(shown?.editor.presets.value.length ?? 0)}`}
          {...pictureData(session)}
          {...cameraData(session)}
        />
        {set ? (
          <p class="glass compare-name">
            <Link href={`/view/${set.id}`} label={t.compare.alone(title)}>
              {title}
            </Link>
            <KindChip set={set} />
          </p>
        ) : null}
        {shown ? <OrientationCube session={shown} leads={role.presents} /> : null}
        <StatusLine session={session} fault={fault} visitor={undefined}>
          {null}
        </StatusLine>
        {shown ? <PhaseLine session={shown} role={role} /> : null}
      </div>
      {shown ? <Presets session={shown} label={t.compare.looksOf(title)} /> : null}
    </div>
  );
}

/** Returns data attributes that describe the camera, for tests and user scripts. */
function cameraData(session: ViewerSession | null): Record<string, string> {
  const camera = session?.editor.scene.value?.camera;
  const numbers = [camera?.eye, camera?.target].flatMap((at) => (at ? [at.x, at.y, at.z] : []));
  return numbers.length > 0 ? { "data-camera": numbers.map((n) => n.toFixed(3)).join(" ") } : {};
}
