// A menu of the site's versions. versions.js beside their folders lists them; a site that is alone has none. It is a
// script and not JSON, because a browser loads no JSON from files.
(() => {
  const place = document.querySelector(".site-versions");
  const root = place.dataset.root || "./";
  const list = document.createElement("script");
  list.src = `${root}../versions.js`;
  list.onload = () => {
    const label = document.createElement("label");
    label.textContent = "Version ";
    const menu = document.createElement("select");
    for (const version of window.procamVersions)
      menu.add(new Option(version, version, false, version === place.dataset.version));
    menu.onchange = () => {
      window.location.href = `${root}../${menu.value}/index.html`;
    };
    label.append(menu);
    place.replaceChildren(label);
  };
  document.head.append(list);
})();
