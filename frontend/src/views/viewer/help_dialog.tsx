import { t } from "../../texts";
import { CloseButton, Dialog } from "../dialog";

export function HelpDialog({ onClose }: { readonly onClose: () => void }) {
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
          {t.viewer.helpRows.map(([what, mouse, touch, keys]) => (
            <tr key={what} class={touch === "" ? "no-touch" : ""}>
              <th scope="row">{what}</th>
              <td>{mouse}</td>
              <td>{touch}</td>
              <td>{keys}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <CloseButton onClick={onClose} />
    </Dialog>
  );
}
