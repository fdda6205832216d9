/** An email address that breaks before the @ if it is too long, not within a word. */
export function Address({ email }: { readonly email: string }) {
  const at = email.lastIndexOf("@");
  return (
    <span>
      {email.slice(0, at)}
      <wbr />
      {email.slice(at)}
    </span>
  );
}
