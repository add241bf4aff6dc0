"""Other ways from direct to indirect light, each as one would write it with its library."""

import numpy as np


def notebook(direct, indirect, rank):
    """The notebook's steps with its types and sizes, and `eigh`."""
    pairs, height, width, _ = indirect.shape
    x = direct.reshape(pairs, -1).astype(np.float64)
    norm = np.linalg.norm(x, axis=1, keepdims=True)
    x /= norm
    y = indirect.astype(np.float64).transpose(0, 3, 1, 2).reshape(pairs, 3, -1)
    y /= norm[..., None]
    rows = y.reshape(3 * pairs, -1)
    mean = rows.mean(axis=0, keepdims=True)
    centred = rows - mean
    vectors = np.linalg.eigh(centred @ centred.T / (pairs - 1))[1][:, ::-1]
    B = np.linalg.qr((vectors[:, :rank].T @ centred).T, mode="reduced")[0].T
    coefficients = (y - mean) @ B.T
    inverse = np.linalg.pinv(x.T @ x + 1e-3 * np.eye(x.shape[1]))
    T = np.einsum("ij,jkc->kic", inverse, np.einsum("ji,ikl->jkl", x.T, coefficients))

    def predict(image):
        length = np.linalg.norm(image)
        p = image.ravel() / length
        z = B.T @ np.stack([p @ T[channel] for channel in range(3)]).T + mean.T
        return length * z.reshape(height, width, 3)

    return predict


def scikit(direct, indirect, rank):
    """PCA and ridge, in float32."""
    from sklearn.decomposition import PCA
    from sklearn.linear_model import Ridge

    pairs, height, width, _ = indirect.shape
    norm = np.linalg.norm(direct.reshape(pairs, -1), axis=1, keepdims=True)
    x = direct.reshape(pairs, -1) / norm
    rows = np.moveaxis(indirect, -1, 1).reshape(3 * pairs, -1) / np.repeat(norm, 3, axis=0)
    pca = PCA(rank, svd_solver="randomized", random_state=0)
    coefficients = pca.fit_transform(rows).reshape(pairs, -1)
    ridge = Ridge(1e-3).fit(x, coefficients)

    def predict(image):
        length = np.linalg.norm(image)
        found = ridge.predict(image.reshape(1, -1) / length).reshape(3, rank)
        return length * np.moveaxis(pca.inverse_transform(found).reshape(3, height, width), 0, -1)

    return predict


def scikit_linear(direct, indirect, rank):
    """Truncated SVD and ridge without means, so that twice the light gives twice the image."""
    from sklearn.decomposition import TruncatedSVD
    from sklearn.linear_model import Ridge

    pairs, height, width, _ = indirect.shape
    norm = np.linalg.norm(direct.reshape(pairs, -1), axis=1, keepdims=True)
    rows = np.moveaxis(indirect, -1, 1).reshape(3 * pairs, -1) / np.repeat(norm, 3, axis=0)
    svd = TruncatedSVD(rank, random_state=0)
    coefficients = svd.fit_transform(rows).reshape(pairs, -1)
    ridge = Ridge(1e-3, fit_intercept=False).fit(direct.reshape(pairs, -1) / norm, coefficients)

    def predict(image):
        found = ridge.predict(image.reshape(1, -1)).reshape(3, rank)
        return np.moveaxis(svd.inverse_transform(found).reshape(3, height, width), 0, -1)

    return predict
