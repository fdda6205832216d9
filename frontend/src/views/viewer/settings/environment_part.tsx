import { useCallback, useEffect, useRef, useState } from "preact/hooks";
import { mostEnvironmentBytes } from "../../../api/environments";
import { ApiProblem } from "../../../api/client";
import type { Environment } from "../../../api/types";
import type { Light } from "../../../protocol/gen/api/proto/scene_pb";
import {
  previewPixels,
  rotationLimits,
  rotationOf,
  setStored,
  storedOf,
  turnEnvironment,
} from "../../../scene/environments";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { Icon } from "../../icons";
import { oneAtATime } from "../../one_at_a_time";
import { UserError, useApp } from "../../state";
import { NameControl, NumberControl } from "./controls";
import { sceneEdits } from "./scene_edits";
import { pngOf } from "./texture_files";
import { Swatch, TextureRow } from "./texture_part";

export interface EnvironmentPartProps {
  readonly session: ViewerSession;
  readonly light: Light;
  readonly index: number;
}

/** The user's own environments for a surrounding light, and its rotation. */
export function EnvironmentPart({ session, light, index }: EnvironmentPartProps) {
  const text = t.settings.light.environment;
  const app = useApp();
  const { list, fault, busy, act } = useEnvironments();
  const { live, rest, apply } = sceneEdits(session.editor);
  const chosen = storedOf(light);
  const choose = (id: string) => apply(`light environment ${index}`, (now) => setStored(now, index, id));
  const add = (file: File) =>
    act(async () => {
      if (file.size > mostEnvironmentBytes) throw new UserError(text.faults.too_large);
      choose((await app.api.environments.add(file)).id);
    });
  const mine = list.find(({ id }) => id === chosen);
  return (
    <>
      {app.me.value ? (
        <DropArea onFile={add}>
          <TextureRow title={text.title} fault={fault} hint={text.hint}>
            {list.map((one) => (
              <button
                key={one.id}
                type="button"
                class="texture"
                aria-pressed={one.id === chosen}
                onClick={() => choose(one.id === chosen ? "" : one.id)}
              >
                <Preview pixels={one.preview} />
                {one.name}
              </button>
            ))}
            <AddEnvironment busy={busy} onFile={add} />
          </TextureRow>
        </DropArea>
      ) : null}
      {mine ? <OwnEnvironment key={mine.id} environment={mine} act={act} onRemoved={() => choose("")} /> : null}
      {chosen && list.length > 0 && !mine ? <p class="hint">{text.notYours}</p> : null}
      {chosen ? (
        <NumberControl
          label={text.rotation}
          unit={t.settings.degrees}
          value={rotationOf(light)}
          limits={rotationLimits}
          rest={rest}
          change={live(`light rotation ${index}`, (now, to: number) => turnEnvironment(now, index, to))}
        />
      ) : null}
    </>
  );
}

/** Runs a change of the user's environments, after which the list is read again. */
type Act = (work: () => Promise<void>) => void;

function useEnvironments() {
  const app = useApp();
  const [list, setList] = useState<readonly Environment[]>([]);
  const [fault, setFault] = useState("");
  const [busy, setBusy] = useState(false);
  const signedIn = Boolean(app.me.value);
  const reload = useCallback(async () => {
    if (signedIn) setList(await app.api.environments.list());
  }, [app, signedIn]);
  useEffect(() => {
    reload().catch((thrown: unknown) => setFault(app.explain(thrown)));
  }, [app, reload]);
  const running = useRef<Act | null>(null);
  running.current ??= oneAtATime(async (work: () => Promise<void>) => {
    setFault("");
    setBusy(true);
    try {
      await work();
      await reload();
    } catch (thrown) {
      setFault(faultText(thrown) ?? app.explain(thrown));
    } finally {
      setBusy(false);
    }
  });
  return { list, fault, busy, act: running.current };
}

/** Returns the text for a file that the server has refused. */
function faultText(thrown: unknown): string | null {
  const [, word = ""] = /^file\.(\w+)$/.exec(thrown instanceof ApiProblem ? (thrown.errors[0]?.field ?? "") : "") ?? [];
  const known: Readonly<Record<string, string>> = t.settings.light.environment.faults;
  return Object.hasOwn(known, word) ? (known[word] ?? null) : null;
}

/** Accepts a file that is dropped on it. */
function DropArea({ onFile, children }: { onFile: (file: File) => void; children: preact.ComponentChildren }) {
  const [over, setOver] = useState(false);
  return (
    <div
      class="drop-area"
      data-over={over ? "" : undefined}
      onDragOver={(event) => {
        event.preventDefault();
        setOver(true);
      }}
      onDragLeave={() => setOver(false)}
      onDrop={(event) => {
        event.preventDefault();
        setOver(false);
        const file = event.dataTransfer?.files[0];
        if (file) onFile(file);
      }}
    >
      {children}
    </div>
  );
}

function AddEnvironment({ busy, onFile }: { readonly busy: boolean; readonly onFile: (file: File) => void }) {
  const text = t.settings.light.environment;
  return (
    <label class="texture texture-own">
      <span class="texture-none" aria-hidden="true">
        +
      </span>
      {busy ? text.reading : text.add}
      <input
        type="file"
        class="visually-hidden"
        accept=".hdr,.exr"
        disabled={busy}
        aria-label={text.addLabel}
        onChange={(event) => {
          const file = event.currentTarget.files?.[0];
          if (file) onFile(file);
          event.currentTarget.value = ""; // so that the same file can be chosen again
        }}
      />
    </label>
  );
}

interface OwnEnvironmentProps {
  readonly environment: Environment;
  readonly act: Act;
  readonly onRemoved: () => void;
}

function OwnEnvironment({ environment, act, onRemoved }: OwnEnvironmentProps) {
  const text = t.settings.light.environment;
  const app = useApp();
  const [sure, setSure] = useState(false);
  const name = environment.name ?? "";
  return (
    <>
      <NameControl
        label={text.name}
        value={name}
        most={60}
        change={(to) => {
          if (to.trim()) act(() => app.api.environments.rename(environment.id, to.trim()));
        }}
      />
      {sure ? <p class="hint">{text.removeSure(name)}</p> : null}
      <p class="saved-acts">
        <button
          type="button"
          class="button button-small"
          onClick={() => {
            setSure(true);
            if (!sure) return;
            act(async () => {
              await app.api.environments.remove(environment.id);
              onRemoved();
            });
          }}
        >
          <Icon name="trash" />
          {text.remove(name)}
        </button>
        {sure ? (
          <button type="button" class="button button-small" onClick={() => setSure(false)}>
            {t.cancel}
          </button>
        ) : null}
      </p>
    </>
  );
}

/** The hexadecimal pixels of an environment as a picture. */
function Preview({ pixels }: { readonly pixels: string }) {
  const [file, setFile] = useState<Uint8Array<ArrayBuffer>>();
  useEffect(() => {
    let here = true;
    void pngOf(previewPixels(pixels)).then((made) => {
      if (here) setFile(made);
    });
    return () => {
      here = false;
    };
  }, [pixels]);
  return <Swatch file={file} />;
}
