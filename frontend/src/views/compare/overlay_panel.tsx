import { useEffect } from "preact/hooks";
import { roleOf } from "../../live/role";
import type { Scene } from "../../protocol/messages";
import { OverlayMode, overlayLookOf, setOverlayMode, setShare, withOverlayLook } from "../../scene/overlay";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Choice } from "../choice";
import { IconButton } from "../icon_button";
import { navigate } from "../router";
import { comparePath } from "../routes";
import { useMedia } from "../use_media";
import { AlignPanel } from "./align_panel";
import { CompareModes } from "./compare_header";
import type { AlignmentTask } from "./use_alignment";

/** A window in which the panel covers nothing of the subject. */
const roomy = "(min-width: 1081px)";

export interface OverlayPanelProps {
  readonly session: ViewerSession;
  readonly first: string;
  readonly second: string;
  /** The name of the second scan. */
  readonly title: string;
  readonly alignment: AlignmentTask;
}

/** How the second scan is shown over the first one, and how well both are aligned. */
export function OverlayPanel({ session, first, second, title, alignment }: OverlayPanelProps) {
  useDefaultOverlay(session);
  const wide = useMedia(roomy);
  const text = t.compare.overlay;
  const live = session.connection.value.phase === "live" && session.editor.scene.value !== null;
  return (
    <aside class="glass overlay-panel" aria-label={text.title}>
      {session.second.value ? <ShareSlider session={session} /> : live ? <p>{text.unavailable}</p> : null}
      <details open={wide}>
        <summary>{title || text.title}</summary>
        <div class="overlay-parts">
          <OverlayControls session={session} />
          <div class="overlay-head">
            <CompareModes first={first} second={second} over />
            <IconButton
              icon="swap"
              label={t.compare.swap}
              onClick={() => navigate(comparePath(second, first, true), true)}
            />
          </div>
          <details class="overlay-align">
            <summary>{text.alignment}</summary>
            <AlignPanel task={alignment} />
          </details>
        </div>
      </details>
    </aside>
  );
}

/** Shows the second scan in its first look when a session begins, or when a saved scene lacks it. */
function useDefaultOverlay(session: ViewerSession): void {
  const { editor } = session;
  const look = session.second.value?.looks[0];
  const lacking = editor.scene.value !== null && editor.scene.value.overlay === undefined;
  const leads = roleOf(session.audience.value).presents;
  useEffect(() => {
    if (!look || !lacking || !leads) return;
    editor.follow((scene) => withOverlayLook(scene, look));
    editor.rest();
  }, [editor, look, lacking, leads]);
}

function OverlayControls({ session }: { readonly session: ViewerSession }) {
  const { editor } = session;
  const text = t.compare.overlay;
  const scene = editor.scene.value;
  const overlay = scene?.overlay;
  if (!scene || !overlay) return null;
  const looks = session.second.value?.looks ?? [];
  const change = (what: string, edit: (scene: Scene) => Scene) => {
    editor.change(`overlay ${what}`, edit);
    editor.rest();
  };
  const shown = overlayLookOf(scene, looks);
  return (
    <>
      <Choice
        label={text.mode}
        value={String(overlay.mode)}
        options={[
          [String(OverlayMode.MIXED), text.modes.mixed],
          [String(OverlayMode.SPLIT), text.modes.split],
        ]}
        onChoose={(mode) =>
          change("mode", (one) =>
            setOverlayMode(one, mode === String(OverlayMode.SPLIT) ? OverlayMode.SPLIT : OverlayMode.MIXED),
          )
        }
      />
      {looks.length > 1 ? (
        <Choice
          label={text.look}
          value={shown ?? ""}
          options={[
            ...looks.map(({ name }) => [name, text.looks[name] ?? name] as const),
            ...(shown === null ? [["", "…"] as const] : []),
          ]}
          onChoose={(name) => {
            const look = looks.find((one) => one.name === name);
            if (look) change("look", (one) => withOverlayLook(one, look));
          }}
        />
      ) : null}
    </>
  );
}

/** How much of each scan is shown. With a divider, each has its side of the picture. */
function ShareSlider({ session }: { readonly session: ViewerSession }) {
  const { editor } = session;
  const text = t.compare.overlay;
  const overlay = editor.scene.value?.overlay;
  if (overlay?.mode !== OverlayMode.MIXED) return null;
  return (
    <div class="overlay-share">
      <span aria-hidden="true">{text.first}</span>
      <input
        type="range"
        min={0}
        max={1}
        step={0.01}
        value={overlay.share}
        aria-label={text.share}
        aria-valuetext={text.shareText(overlay.share)}
        onInput={({ currentTarget: { valueAsNumber } }) =>
          editor.change("overlay share", (scene) => setShare(scene, valueAsNumber), true)
        }
        onChange={() => editor.rest()}
      />
      <span aria-hidden="true">{text.second}</span>
    </div>
  );
}
