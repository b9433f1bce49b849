// Browsers start no Worker from a file, so that search would not work in a folder. This one runs its script in a hidden frame.
if (location.protocol == "file:") {
    window.Worker = class extends EventTarget {
        constructor(url) {
            super();
            const frame = document.createElement("iframe");
            frame.hidden = true;
            this.ready = new Promise(done => { frame.onload = () => done(frame.contentWindow); });
            frame.addEventListener("message", event => this.dispatchEvent(new MessageEvent("message", {data: event.data})));
            frame.srcdoc = `<script>
                postMessage = data => frameElement.dispatchEvent(new MessageEvent("message", {data}));
                importScripts = (...urls) => Promise.all(urls.map(url => new Promise((done, failed) => {
                    const script = Object.assign(document.createElement("script"), {src: url, onload: done, onerror: failed});
                    document.head.append(script);
                })));
            <\/script><script src="${url}"><\/script>`;
            document.body.append(frame);
        }
        postMessage(data) {
            this.ready.then(scope => scope.dispatchEvent(new MessageEvent("message", {data})));
        }
        terminate() {}
    };
}
