import { t } from "../../texts";
import { CloseButton, Dialog } from "../dialog";
import { Icon, type IconName } from "../icons";
import { useMedia } from "../use_media";

export interface HelpDialogProps {
  /** Which of the buttons this viewer has. */
  readonly has: {
    readonly slices: boolean;
    readonly account: boolean;
    readonly presets: boolean;
    readonly sharing: boolean;
    readonly phases: boolean;
  };
  /** The number of looks to choose from. */
  readonly looks: number;
  readonly onClose: () => void;
}

export function HelpDialog({ has, looks, onClose }: HelpDialogProps) {
  return (
    <Dialog title={t.viewer.help} onClose={onClose}>
      <table class="help">
        <thead>
          <tr>
            {t.viewer.helpHeads.map((head) => (
              <th key={head} scope="col">
                {head}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {[...t.viewer.helpRows(looks), ...(has.phases ? t.phases.helpRows : [])].map(([what, mouse, touch, keys]) => (
            <tr key={what} class={touch === "" ? "no-touch" : ""}>
              <th scope="row">{what}</th>
              <td>{mouse}</td>
              <td>{touch}</td>
              <td>{keys}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <Buttons has={has} />
      <CloseButton onClick={onClose} />
    </Dialog>
  );
}

/** Names the buttons that show only an icon, because a touch screen has no tooltips. */
function Buttons({ has }: Pick<HelpDialogProps, "has">) {
  const { windows } = t.settings;
  const narrow = useMedia("(max-width: 520px)"); // compare.css hides the button there
  const all: readonly (readonly [IconName, string, boolean])[] = [
    ["four", t.viewer.helpButtons.slices, has.slices],
    ["reset", t.viewer.reset, true],
    ["camera", t.viewer.screenshot, true],
    ["record", t.recording.open, has.account],
    ["star", t.presets.open, has.presets],
    ["compare", t.compare.open, has.presets && !narrow],
    ["globe", t.sharing.open, has.sharing],
    ["people", t.live.open, true],
    ["undo", t.settings.undo, true],
    ["redo", t.settings.redo, true],
    ["eye", windows.view, true],
    ["palette", windows.look, true],
    ["lamp", windows.light, true],
    ["aperture", windows.lens, true],
    ["slice", windows.cuts, true],
    ["pencil", windows.marks, true],
  ];
  return (
    <section>
      <h3>{t.viewer.helpButtons.title}</h3>
      <ul class="help-buttons">
        {all.map(([icon, name, there]) =>
          there ? (
            <li key={icon}>
              <Icon name={icon} /> {name}
            </li>
          ) : null,
        )}
      </ul>
    </section>
  );
}
