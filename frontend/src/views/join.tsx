import { useMemo, useState } from "preact/hooks";
import { guest_place, new_guest, remembered_guest } from "../live/place";
import { tab } from "../storage";
import { t } from "../texts";
import { AccountFrame } from "./account_frame";
import { Field } from "./field";
import { Shell } from "./shell";
import { useApp } from "./state";
import { Viewer } from "./viewer/viewer";

/** Where a link leads: a name, if one likes, and then the picture. No account is needed. */
export function Join({ token }: { readonly token: string }) {
  const app = useApp();
  const [guest, set_guest] = useState(() => remembered_guest(tab, token));
  const [name, set_name] = useState("");
  const place = useMemo(() => (guest ? guest_place(app.api, token, guest) : null), [app, token, guest]);
  if (place) return <Viewer place={place} title={t.live.guest_title} />;
  return (
    <Shell>
      <AccountFrame title={t.live.join_title} lead={t.live.join_lead}>
        <form
          noValidate
          onSubmit={(event) => {
            event.preventDefault();
            set_guest(new_guest(tab, token, name));
          }}
        >
          <Field label={t.live.name} value={name} onInput={set_name} autocomplete="nickname" hint={t.live.name_hint} most={40} />
          <button type="submit" class="button button-main">{t.live.join}</button>
        </form>
      </AccountFrame>
    </Shell>
  );
}
